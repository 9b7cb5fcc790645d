"""A robot's file is read once; other models are derived from the parsed file."""

import pickle

import mujoco
import numpy as np
import pytest

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
