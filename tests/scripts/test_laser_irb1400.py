"""`armside laser --robot irb1400`: the same experiment on the robot of chapter 5."""

from pathlib import Path

import numpy as np
import pytest
from tests.claims._learned import run

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.measures import norms as measures
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.cutting.specification import measure
from armside.sim.cell import IRB1400_CELL
from armside.sim.laser.design import THESIS, default_design
from armside.sim.laser.design_from_data import design_from_data
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.specification import Cut
from armside.sim.robot.virtual_robot import LOG_PERIOD

NORMS = ("motor_two", "motor_inf")


def worst_motor(cut, design=None):
    """Largest motor error after five iterations in both norms, as (9.5), and the arm's RMS."""
    rows = run(cut, design, seed=1)["iterations"]
    worst = []
    for norm in NORMS:
        first, last = (np.array(rows[k][norm]) for k in (0, 5))
        worst.append(measures.normalise(last, first).max())
    return *worst, [row["arm_rms"] for row in rows]


@pytest.mark.parametrize("pose", ["p1", "p2", "p3"])
def test_it_learns_its_motors_down_to_a_tenth_in_either_norm(pose):
    two, largest, arm = worst_motor(Cut(robot="irb1400", pose=pose))
    assert two <= 0.10
    assert largest <= 0.10
    assert arm[5] < 0.5 * arm[0]  # the tracker's result beside them


def test_the_design_of_the_thesis_leaves_more_at_reversals():
    """They are the spikes where a motor reverses against stiction: above its cutoff, too late."""
    two, largest, _ = worst_motor(Cut(robot="irb1400"))
    thesis = worst_motor(Cut(robot="irb1400"), THESIS)
    assert thesis[0] > two
    assert thesis[1] > 1.5 * largest


def test_its_design_is_what_its_own_learning_data_ask_for():
    asked = design_from_data(Cut(robot="irb1400"), seed=1).proposal
    ours = default_design(IRB1400_CELL)
    assert (asked.delta, asked.cutoff) == (ours.delta[0], ours.cutoff[0])
    assert asked.gamma == pytest.approx(ours.gamma[0], abs=0.05)


def test_a_design_belongs_to_a_robot_that_learns_from_its_motors():
    assert LaserCfg().delta == THESIS.delta
    ours = LaserCfg(robot="irb1400")
    assert (ours.gamma, ours.delta, ours.cutoff) == ((1.0,), (8,), (20.0,))
    Q = default_design(IRB1400_CELL).law.Q
    assert isinstance(Q, ZeroPhaseButterworth)
    assert Q.sample_time == LOG_PERIOD
    assert LaserCfg(robot="irb1400", delta=(5,)).delta == (5,)
    assert LaserCfg(robot="irb1400", measure="tracker").delta == THESIS.delta


def test_a_law_on_the_nominal_robot_learns_motors_and_no_twin():
    found = measure(LaserCfg(robot="irb1400", law="simulated"))
    assert isinstance(found, MotorAngles)
    assert found.simulated
    with pytest.raises(ValueError, match="law simulated needs --measure motor"):
        LaserCfg(law="simulated", measure="tracker")
    with pytest.raises(ValueError, match="learns on the nominal robot: give no twin with it"):
        LaserCfg(law="simulated", twin=Path("twin"))


@pytest.mark.parametrize(
    ("given", "cutoff"), [({}, None), ({"cutoff": (13.0,)}, None), ({"cutoff": (10.0,)}, 10.0)]
)
def test_the_default_pass_band_follows_the_arm_and_another_cutoff_is_kept(given, cutoff):
    law = measure(LaserCfg(robot="irb1400", measure="estimate", **given)).law
    assert law.cutoff == cutoff
    assert not LaserCfg(robot="irb1400").up_to_mode  # motors have no pass band of an arm
