"""Effects of gears and drives: each has its documented size, and a loaded design has none."""

import mujoco
import numpy as np
import pytest

from armside.sim.robot.effects import Effect, available, with_effects
from armside.sim.robot.mjcf import axis_actuators
from armside.sim.robot.statics import spring_stiffness
from armside.sim.robot.virtual_robot import VirtualRobot

POSE = np.deg2rad([3.5, 7.8, 12.4, 18.2, -9.2, -11.6])


def _still(n=120):
    return np.repeat(POSE[None], n, axis=0)


def test_the_large_robot_has_data_for_all_and_the_irb1400_for_none(design, irb1400):
    assert available(design) == frozenset(Effect)
    assert available(irb1400) == frozenset()


def test_effects_leave_the_model_they_are_added_to_alone(design):
    before = design.mj.actuator_biasprm.copy(), design.mj.jnt_stiffness.copy()
    with_effects(design, Effect, phi=POSE)
    assert np.array_equal(before[0], design.mj.actuator_biasprm)
    assert np.array_equal(before[1], design.mj.jnt_stiffness)


def test_a_gear_with_lost_motion_is_soft_inside_and_stiff_outside(design):
    soft = with_effects(design, {Effect.LOST_MOTION}, phi=POSE)
    data = mujoco.MjData(soft.mj)
    stiff = design.mj.joint("flex_1").stiffness[0]
    half = soft.mj.numeric("gear_lost_motion").data[0]

    def torque(angle):
        data.qpos[:] = 0.0
        data.qpos[soft.flex[0]] = angle
        mujoco.mj_forward(soft.mj, data)
        return -data.qfrc_spring[soft.flex[0]]

    inside = torque(0.5 * half) / (0.5 * half)
    outside = (torque(5 * half) - torque(4 * half)) / half
    assert inside == pytest.approx(soft.mj.numeric("gear_soft_stiffness").data[0], rel=1e-9)
    assert outside == pytest.approx(stiff, rel=1e-6)
    assert torque(-3 * half) == pytest.approx(-torque(3 * half))
    assert spring_stiffness(soft) == pytest.approx(spring_stiffness(design))


def test_a_transmission_error_moves_the_tool_but_not_the_encoder(design):
    """Slow motion of axis 1 by one motor revolution: the tool leaves the line by the error."""
    turn = 2 * np.pi / design.drives.gear[0]
    reference = _still(1500)
    reference[:, 0] += turn * 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, 1500)))
    tools = []
    for effects in ((), {Effect.GEAR_ERROR}):
        robot = VirtualRobot(with_effects(design, effects, phi=POSE))
        recording = robot.run(reference)
        tools.append(recording.truth.tool_position)
        assert np.abs(recording.error).max() < 2e-3
    apart = np.linalg.norm(tools[1] - tools[0], axis=1)
    radius = np.hypot(*tools[0][0, :2])
    amplitude = design.mj.numeric("gear_error").data
    assert apart.max() < 2.5 * 6 * amplitude.sum() * radius  # six axes at once, at most
    assert np.ptp(apart) > amplitude[2] * radius  # the part of the motor's own turn


def test_ripple_is_a_torque_of_the_motor_angle(design):
    rough = with_effects(design, {Effect.RIPPLE}, phi=POSE)
    amplitude, order = rough.mj.numeric("torque_ripple").data
    peak = amplitude * design.drives.torque_limit
    bias = rough.mj.actuator_biasprm[axis_actuators(rough.mj)]
    assert bias[:, :2] == pytest.approx(np.column_stack([peak, np.full(6, order)]))


def test_ripple_does_not_move_a_robot_that_has_come_to_rest(design):
    """The servo holds the ripple at the angles where it stands: a run starts without a jump."""
    run = VirtualRobot(with_effects(design, Effect, phi=POSE)).run(_still())
    truth, count = run.truth, 2 * np.pi / 16384 / design.drives.gear
    assert (np.abs(run.error) <= 0.51 * count).all()  # also with a gear error
    assert (np.ptp(truth.gear_angle, axis=0) < 0.05 * count).all()
    assert np.ptp(truth.tool_position, axis=0).max() < 1e-6
