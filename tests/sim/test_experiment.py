"""One learning experiment on the large robot: the story of thesis chapter 9."""

import numpy as np
import pytest

from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic
from armside.sim.cell import LARGE_CELL, LARGE_ROBOT_POSES
from armside.sim.cut.task import CircleTask
from armside.sim.evaluation.tool_error import tool_error
from armside.sim.laser.experiment import iterate, prepare
from armside.sim.robot.model import load_model
from armside.sim.robot.virtual_robot import LOG_PERIOD


@pytest.fixture(scope="module")
def model():
    return load_model(LARGE_CELL.xml)


def _experiment(model, pose="p1", seed=0, **task):
    return prepare(LARGE_CELL, model, CircleTask(pose=LARGE_ROBOT_POSES[pose], **task), seed=seed)


def _law(cutoff=10.0, delta=3, gamma=0.9):
    return Heuristic(Q=ZeroPhaseButterworth(cutoff, LOG_PERIOD), gamma=gamma, delta=delta)


def test_tracker_and_truth_agree_on_the_circle(model):
    (first,) = iterate(_experiment(model), _law(), 0)
    assert first.arm.rms == pytest.approx(first.arm_true.rms, abs=2e-6)
    assert first.arm.maxdev == pytest.approx(first.arm_true.maxdev, abs=30e-6)  # noise, 785 samples


def test_motor_error_is_that_of_the_motor_shaft(model):
    (first,) = iterate(_experiment(model), _law(), 0)
    assert first.motor_error == pytest.approx(first.trial.error * model.drives.gear)


def test_controller_knows_the_nominal_robot_only(model):
    """Individuals of other friction are asked for the same reference."""
    one, other = _experiment(model, seed=1), _experiment(model, seed=2)
    assert np.array_equal(one.loaded.reference, other.loaded.reference)
    friction = [e.loaded.model.mj.actuator_biasprm[:, 3] for e in (one, other)]
    assert not np.array_equal(*friction)


def test_a_turn_with_a_lost_beam_has_no_measure(model):
    experiment = _experiment(model)
    (first,) = iterate(experiment, _law(), 0)
    seen = first.trial.result.tracker
    position = seen.position.copy()
    position[len(position) // 2 :] = np.nan
    side = tool_error(experiment.motion, seen.time, position)
    assert np.isnan(side.rms)
    assert np.isnan(side.maxdev)
    assert np.isfinite(side.path).all()


def test_circle_across_the_tool_is_perpendicular_to_its_axis(model):
    pose = LARGE_ROBOT_POSES["p1"]
    path = CircleTask(pose=pose, across_tool=True).path
    points = path.position(np.linspace(0, path.length, 50)) - np.array(pose.position)
    assert np.abs(points @ pose.tool_axis).max() < 1e-15


def test_a_bold_law_diverges_and_says_so(model):
    trials = list(iterate(_experiment(model), _law(gamma=3.0), 10))
    assert trials[-1].trial.diverged
    assert len(trials) < 11
