"""Deflection along a rigid motion against the whole arm, and the structure that is assumed."""

import mujoco
import numpy as np
import pytest

from armside.arrays import Array
from armside.assets import LARGE_ROBOT_XML
from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.estimation.deflection import deflection
from armside.sim.estimation.elasticity import nominal_elasticity
from armside.sim.estimation.estimator import tool_path
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.estimation.rigid_motion import ENCODER_FILTER, REACH, rigid_motion, segments
from armside.sim.estimation.structure import across, with_structure
from armside.sim.robot.model import load_model

from .rollout import observe

PERIOD = 0.004
TIME: Array = np.arange(500, dtype=np.float64) * PERIOD


@pytest.fixture(scope="module")
def robot():
    return load_model(LARGE_ROBOT_XML)


@pytest.fixture(scope="module")
def arm(robot):
    return nominal_arm(with_structure(robot))


@pytest.fixture(scope="module")
def springs(robot, arm):
    return nominal_elasticity(robot, arm)


def moved(extent):
    """(N, 6) [rad]: all axes turn by an extent and swing, from rest to rest."""
    rest = np.array([0.1, -0.2, 0.5, -0.1, 0.3, 0.2])
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.clip((TIME - 0.3) / 1.2, 0.0, 1.0))
    swing = 2e-3 * ramp * (1.0 - ramp) * np.sin(2.0 * np.pi * 3.0 * TIME)
    return rest + (extent * ramp + swing)[:, None] * np.array([1.0, -0.5, 0.7, 1.0, -1.0, 0.5])


def test_it_is_the_motion_of_the_whole_arm(arm, springs):
    """MuJoCo's rollout of gears and structure with linear springs, over 0.15 rad in 1.2 s.

    It is exact at rest; what differs is the phase in which the arm rings after so fast a move.
    """
    phi = moved(0.15)
    motion = rigid_motion(arm, TIME, phi)
    whole = observe(arm, phi, PERIOD).tool_position[::8]
    whole = whole - whole[:25].mean(axis=0)
    found, rigid = (
        np.linalg.norm(tool_path(motion, deflection(motion, linear(springs, k)))[:, :3] - whole)
        for k in (1.0, 1e3)
    )
    assert found < 0.05 * rigid


def linear(springs, factor=1.0):
    return springs.scaled(np.full(len(springs.stiffness), factor), factor, factor, 0.0)


def test_a_gear_without_load_is_soft_within_its_lost_motion(arm, springs):
    """Axis 1 carries no weight: at rest it hangs in the middle, and gives way six times as much."""
    first, motion = int(springs.axes[0]), rigid_motion(arm, TIME, moved(0.0))
    soft, wound = (deflection(motion, s).angle[:, first] for s in (springs, linear(springs)))
    assert abs(soft[0]) < springs.lost_motion[first]
    assert np.ptp(soft) > 2.0 * np.ptp(wound)


def test_springs_that_cannot_carry_the_arm_are_refused(arm, springs):
    weak = springs.scaled(np.full(len(springs.stiffness), 1e-4), 1e-4, 1e-4, 1.0)
    with pytest.raises(FloatingPointError, match="cannot carry"):
        deflection(rigid_motion(arm, TIME, moved(0.15)), weak)


def test_the_structure_gives_way_across_each_of_the_first_axes_and_tilts_on_the_floor(robot):
    for axis in range(3):
        along = np.array(robot.mj.joint(f"motor_{axis + 1}").axis)
        directions = np.array([hinge.axis for hinge in across(robot, axis)])
        assert directions @ directions.T == pytest.approx(np.eye(2))
        assert directions @ along == pytest.approx(np.zeros(2))
    data = mujoco.MjData(robot.mj)
    mujoco.mj_kinematics(robot.mj, data)
    for hinge in across(robot, 0):
        body = robot.mj.body(hinge.body).id
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array(hinge.position)
        assert place == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_segment_ends_where_an_angle_has_changed_by_its_reach():
    smooth = ZeroPhaseButterworth(ENCODER_FILTER, PERIOD)(moved(0.15))
    index = segments(smooth)
    assert (np.diff(index) >= 0).all()
    for one in range(index[-1] + 1):
        assert np.ptp(smooth[index == one], axis=0).max() <= 1.1 * REACH
