"""The plant of the tool's law: servo, gears and arm in one response."""

from copy import copy
from dataclasses import replace

import numpy as np

from armside.assets import LARGE_ROBOT_XML
from armside.sim.estimation.arm_plant import ArmPlant
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.robot.mjcf import AXES
from armside.sim.robot.model import load_model

PHI, VISCOUS = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1]), 0.03
"""[N m s/rad], of the motor's shaft."""


def test_viscous_friction_of_a_motor_acts_as_damping_of_its_servo_at_rest():
    """Both are torque of the motor per speed of the motor: all of one can stand in the other."""
    robot = load_model(LARGE_ROBOT_XML)
    arm, drives, axes = linearised(nominal_arm(robot), PHI), robot.drives, robot.mj.actuator
    rubbing, free = copy(robot.mj), copy(robot.mj)
    for axis in AXES:
        rubbing.actuator_damping[axes(f"axis_{axis}").id] = VISCOUS
        free.actuator_damping[axes(f"axis_{axis}").id] = 0.0
    kd = drives.kd + VISCOUS
    share = drives.velocity_feedforward * drives.kd / kd  # of the reference's speed, as before
    damped = replace(drives, kd=kd, velocity_feedforward=share)
    omega = 2.0 * np.pi * np.array([0.5, 3.0, 8.0, 12.0, 20.0]) * 0.004
    robots = (
        replace(robot, mj=rubbing),
        replace(robot, mj=free, drives=damped),
        replace(robot, mj=free),
    )
    by_friction, by_servo, none = (
        ArmPlant(robot=one, arm=arm, period=0.004).response(omega) for one in robots
    )
    np.testing.assert_allclose(by_friction, by_servo, rtol=1e-9, atol=1e-9)
    assert np.abs(none - by_friction).max() > 0.01 * np.abs(none).max()
