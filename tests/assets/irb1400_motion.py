"""Poses and motions of the IRB1400 that its tests share."""

from itertools import pairwise

import mujoco
import numpy as np

from armside.sim.robot.mjcf import AXES

LOG_PERIOD = 0.004


def at_rest_pose(model, phi):
    """Kinematics of the model with its springs at zero."""
    data = mujoco.MjData(model.mj)
    data.qpos[:] = model.posture @ phi
    mujoco.mj_forward(model.mj, data)
    return data


def through(waypoints, seconds):
    """Log-rate reference that visits the rows of `waypoints`, at rest at each."""
    n = round(seconds / LOG_PERIOD)
    ramp = (1.0 - np.cos(np.pi * np.arange(n) / n))[:, None] / 2.0
    legs = [a + ramp * (b - a) for a, b in pairwise(waypoints)]
    rest = np.tile(waypoints[-1], (25, 1))
    return np.concatenate((np.tile(waypoints[0], (25, 1)), *legs, rest))


def brisk_motion():
    """One second that uses all axes: up to 1.3 rad/s on the main axes, 5 rad/s^2."""
    there = np.array([0.4, 0.35, -0.25, 0.6, 0.5, -0.7])
    return through(np.array([np.zeros(6), there, np.zeros(6)]), 0.5)


def held(model, phi, seconds=0.25):
    """The robot with its brakes engaged at phi, after it came to rest."""
    mj = model.mj
    data = at_rest_pose(model, phi)
    for i in AXES:
        brake = mj.eq(f"brake_{i}").id
        mj.eq_data[brake, 0] = phi[i - 1]
        data.eq_active[brake] = 1
    data.ctrl.reshape(6, 3)[:, 0] = model.drives.gear * phi
    for _ in range(round(seconds / mj.opt.timestep)):
        mujoco.mj_step(mj, data)
    return data
