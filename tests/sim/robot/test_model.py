"""A robot's file is read once; other models are derived from the parsed file."""

import pickle
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from armside.assets import IRB1400_XML, LARGE_ROBOT_XML
from armside.sim.cell import LARGE_CELL
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.laser import Cut, learn
from armside.sim.robot.mjcf import ModelError
from armside.sim.robot.model import load_model


@pytest.fixture
def parses(monkeypatch):
    """Every source that MuJoCo parses, appended as it does."""
    found = []

    def counted(parse):
        return lambda *args, **named: (found.append(args[0]), parse(*args, **named))[1]

    for kind, names in (
        (mujoco.MjModel, ("from_xml_path", "from_xml_string")),
        (mujoco.MjSpec, ("from_file", "from_string")),
    ):
        for name in names:
            monkeypatch.setattr(kind, name, staticmethod(counted(getattr(kind, name))))
    return found


@pytest.mark.usefixtures("quick_identification")
def test_learning_from_the_estimate_reads_the_robot_file_once(parses):
    assert len(list(learn(Cut(), measure="estimate", iterations=1))) == 2
    assert parses == [str(LARGE_CELL.xml)]


def test_deriving_a_model_leaves_the_parsed_file_as_it_was():
    robot = load_model(LARGE_CELL.xml)
    heavy = nominal_arm(robot, NominalCfg(payload=20.0))
    again, fresh = nominal_arm(robot), nominal_arm(load_model(LARGE_CELL.xml))
    assert np.array_equal(again.mj.body_mass, fresh.mj.body_mass)
    assert np.array_equal(again.mj.body_inertia, fresh.mj.body_inertia)
    assert heavy.mj.body_mass.sum() == pytest.approx(again.mj.body_mass.sum() + 20.0)
    assert robot.parsed().compile().signature == robot.mj.signature


def test_a_model_without_its_file_runs_but_derives_no_other():
    robot = load_model(LARGE_CELL.xml)
    for other in (load_model(robot.mj), pickle.loads(pickle.dumps(robot))):
        assert np.array_equal(other.drives.gear, robot.drives.gear)
        with pytest.raises(ModelError, match="loaded from its file"):
            nominal_arm(other)


@pytest.mark.filterwarnings("ignore")  # of MuJoCo
@pytest.mark.parametrize(
    ("text", "other", "said"),
    [
        ('mass="600"', 'mass="-600"', "mass of the body .* must be >= 0 kg, got -600"),
        ('name="gear_ratio" data="', 'name="gear_ratio" data="-', "gear_ratio must be above 0"),
        ('name="encoder_counts" data="', 'name="encoder_counts" data="-', "encoder_counts must be"),
        ('name="correction_delay" data="', 'name="correction_delay" data="-', "must be >= 0, got"),
        ('name="torque_noise" data="1e-4', 'name="torque_noise" data="nan', "must be finite"),
        ('stiffness="', 'stiffness="-', "stiffness of the joint .* must be >= 0"),
        ('damping="', 'damping="-', "damping of the joint .* must be >= 0"),
        ('armature="', 'armature="-', "armature of the joint .* must be >= 0"),
    ],
)
def test_a_number_that_no_robot_has_is_named(tmp_path, text, other, said):
    robot = Path(LARGE_ROBOT_XML).read_text(encoding="utf-8")
    assert text in robot
    (tmp_path / "robot.xml").write_text(robot.replace(text, other, 1), encoding="utf-8")
    with pytest.raises(ModelError, match=said):
        load_model(tmp_path / "robot.xml")


@pytest.mark.parametrize("file", [LARGE_ROBOT_XML, IRB1400_XML])
def test_both_robots_are_plausible_and_phases_may_be_negative(tmp_path, file):
    robot = Path(file).read_text(encoding="utf-8")
    changed = re.sub('name="gear_error_phase" data="', 'name="gear_error_phase" data="-', robot)
    (tmp_path / "robot.xml").write_text(changed, encoding="utf-8")
    load_model(tmp_path / "robot.xml")
