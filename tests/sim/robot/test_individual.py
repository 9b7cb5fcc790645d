"""Individuals have their parameters, payloads their weight, and the design does not change."""

import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from armside.sim.laser import Cut, prepare
from armside.sim.robot.individual import (
    Individual,
    with_individual,
    with_payload,
)
from armside.sim.robot.spread import PRODUCTION, Spread, draw
from armside.sim.robot.statics import Statics
from armside.sim.robot.virtual_robot import VirtualRobot

GRAVITY = 9.82  # [m/s^2], of the model


def _individual(design, seed=0, **spread):
    rng = np.random.default_rng(seed)
    return draw(rng, design, Spread(**spread))


def test_the_default_individual_is_the_design_to_the_last_bit(design, reference):
    same = with_individual(design, Individual())
    runs = [VirtualRobot(model).load(reference).run() for model in (design, same)]
    assert np.array_equal(runs[0].motor_angle, runs[1].motor_angle)
    assert np.array_equal(runs[0].truth.tool_position, runs[1].truth.tool_position)


def test_an_individual_leaves_its_design_alone(design):
    before = design.mj.jnt_stiffness.copy(), design.mj.body_quat.copy()
    other = with_individual(design, _individual(design, 1)).mj
    assert not np.array_equal(other.jnt_stiffness, design.mj.jnt_stiffness)
    assert np.array_equal(design.mj.jnt_stiffness, before[0])
    assert np.array_equal(design.mj.body_quat, before[1])


def test_geometry_errors_move_the_tool_by_millimetres(design, reference):
    """Millimetres at the tool, from half a millimetre and half a milliradian at each joint."""
    import mujoco

    def tool(model):
        data = mujoco.MjData(model.mj)
        data.qpos[:] = model.posture @ reference[0]
        mujoco.mj_kinematics(model.mj, data)
        return data.site("tool0").xpos.copy()

    off = [
        np.linalg.norm(tool(with_individual(design, _individual(design, seed))) - tool(design))
        for seed in range(20)
    ]
    assert 0.5e-3 < np.median(off) < 5e-3
    still = _individual(design, position=0.0, orientation=0.0)
    assert tool(with_individual(design, still)) == pytest.approx(tool(design), abs=1e-12)


def test_the_torque_of_a_payload_at_the_elbow_is_weight_times_lever(design):
    """Stretched forward in the zero pose: 0.25 m beyond the flange, gravity down."""
    heavy = with_payload(design, 140.0)
    forces = [
        Statics(m).rigid_forces(np.zeros((1, 6)), np.zeros((1, 6)), np.zeros((1, 6)))[0]
        for m in (design, heavy)
    ]
    elbow_to_tool = 1.142 + 0.2 + 0.25
    more = (forces[1] - forces[0])[design.motor[2]]
    assert abs(more) == pytest.approx(100.0 * GRAVITY * elbow_to_tool, rel=1e-9)


def test_a_payload_changes_the_tool_alone(design):
    heavy, none = with_payload(design, 175.0), with_payload(design, 0.0)
    total = design.mj.body_mass.sum()
    assert heavy.mj.body_mass.sum() == pytest.approx(total + 135.0)
    assert none.mj.body_mass.sum() == pytest.approx(total - 40.0)
    changed = np.flatnonzero(heavy.mj.body_mass != design.mj.body_mass)
    assert [design.mj.body(int(i)).name for i in changed] == ["tool"]
    ratio = heavy.mj.body("tool").inertia / design.mj.body("tool").inertia
    assert ratio == pytest.approx(175.0 / 40.0)


def test_the_feedforward_is_that_of_the_nominal_model(design):
    def fed_forward(cut):
        loaded = prepare(cut, nominal=design).loaded
        torque = loaded.controls.reshape(-1, 6, 3)[:, :, 2]
        return torque - torque[0]  # what holds the arm at rest is found by the servo

    unaware, unloaded, aware = (
        fed_forward(cut)
        for cut in (Cut(payload=175.0, payload_known=False), Cut(), Cut(payload=175.0))
    )
    assert unaware == pytest.approx(unloaded, abs=1e-9)
    assert (np.ptp(aware, axis=0)[1:] > 1.1 * np.ptp(unaware, axis=0)[1:]).all()


def test_a_repetition_is_the_same_robot_with_other_noise(design):
    first, again, other = (prepare(Cut(), nominal=design, seed=3, repetition=r) for r in (0, 0, 1))
    assert np.array_equal(first.loaded.controls, other.loaded.controls)
    assert np.array_equal(
        first.loaded.model.mj.actuator_biasprm, other.loaded.model.mj.actuator_biasprm
    )
    draws = [e.plant.rng.standard_normal(4) for e in (first, again, other)]
    assert np.array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])


@pytest.mark.parametrize("mass", [-1.0, np.nan, np.inf])
def test_a_negative_payload_is_refused(design, mass):
    with pytest.raises(ValueError, match="payload must be >= 0 kg"):
        with_payload(design, mass)


def test_a_robot_without_a_tool_of_its_own_says_so(irb1400):
    with pytest.raises(ValueError, match="lacks the body tool"):
        with_payload(irb1400, 5.0)


def test_a_negative_spread_is_refused():
    with pytest.raises(ValueError, match="spread of friction must be >= 0"):
        Spread(friction=-0.1)


DOCS = Path(__file__).parents[3] / "docs"


def table(page: str, head: str) -> list[list[str]]:
    """Cells of the rows of a table under a heading `Individuals`."""
    text = (DOCS / page).read_text(encoding="utf-8")
    rows = text.partition("\n## Individuals\n")[2].partition("\n## ")[0].partition(head)[2]
    block = rows.partition("\n\n")[0].splitlines()[1:]
    return [
        [cell.strip() for cell in line.strip("|").split("|")] for line in block if "---" not in line
    ]


def test_the_table_of_distributions_is_that_of_the_production_line():
    rows = table("hardware.md", "| spread |")
    stated = {row[0].strip("`"): float(row[3].split()[0]) for row in rows}
    assert stated == {field.name: getattr(PRODUCTION, field.name) for field in fields(Spread)}


@pytest.mark.parametrize("name", ["position", "centre_of_mass"])
def test_widths_that_are_no_fractions_have_their_unit(name):
    (row,) = [row for row in table("hardware.md", "| spread |") if row[0] == f"`{name}`"]
    assert row[3].endswith(" m")


def test_the_table_of_parameters_names_every_field_of_an_individual():
    rows = table("formats.md", "| parameter |")
    named = [name for row in rows for name in re.findall(r"`\[*(\w+)\]*`", row[0])]
    of_files = {field.name for field in fields(Individual)} - {"alien"}
    assert sorted(named) == sorted(of_files)
