"""The physics of the IRB1400: modes, springs, rest, brakes, variants and servo.

The modes were found with an independent prototype of the same data.
"""

import mujoco
import numpy as np
import pytest
import scipy.linalg

from armside import assets
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.linkage import Linkage
from armside.sim.robot.mjcf import AXES
from armside.sim.robot.model import load_model
from armside.sim.robot.virtual_robot import VirtualRobot

from .irb1400_motion import at_rest_pose, brisk_motion, held

G = 9.82


def imu_position(truth):
    """(M, 3) from tool position and orientation, with the mounting of thesis 5.1.1."""
    in_tool = np.array([-0.090, -0.026, 0.032])  # (32, -26, 90) mm of the zero pose, in tool axes
    moved = np.empty_like(truth.tool_position)
    for i, q in enumerate(truth.tool_quaternion):
        mujoco.mju_rotVecQuat(moved[i], in_tool, q)
    return truth.tool_position + moved


# Soundness of the physics


@pytest.mark.parametrize("flexibility", list(Flexibility))
def test_the_accelerometer_is_the_second_difference_of_the_imu_position(flexibility):
    model = load_model(variant(assets.IRB1400_XML, flexibility))
    truth = VirtualRobot(model).run(brisk_motion(), rng=np.random.default_rng(0)).truth
    position, step = imu_position(truth), model.timestep
    measured = np.diff(position, 2, axis=0) / step**2 + np.array([0.0, 0.0, G])
    specific_force = np.empty_like(measured)
    # IMU and base axes agree in the zero pose: R_base_imu = R_base_tool (R_base_tool of zero)^T.
    zero = np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0])
    for i, tool in enumerate(truth.tool_quaternion[1:-1]):
        imu = np.empty(4)
        mujoco.mju_mulQuat(imu, tool, zero)
        mujoco.mju_rotVecQuat(specific_force[i], truth.imu_acceleration[i + 1], imu)
    rms = np.sqrt(np.mean((measured - specific_force) ** 2, axis=0))
    assert np.ptp(measured, axis=0).min() > 1.0
    assert rms.max() < 0.005


def locked_modes(model):
    """Frequencies [Hz], damping ratios and shapes (nv, n) with the motors held, zero pose."""
    mj, data = model.mj, at_rest_pose(model, np.zeros(6))
    mass = np.zeros((mj.nv, mj.nv))
    mujoco.mj_fullM(mj, data, mass)
    Z = Linkage(mj).tangent(data)[:, model.springs]
    M, K, D = (Z.T @ A @ Z for A in (mass, np.diag(mj.jnt_stiffness), np.diag(mj.dof_damping)))
    squared, shape = scipy.linalg.eigh(K, M)
    w = np.sqrt(squared)
    return w / (2 * np.pi), np.diag(shape.T @ D @ shape) / (2 * w), Z @ shape


def test_the_line_near_27_hz_is_a_mode_of_the_locked_arm(full):
    """Thesis 5.1.1: a small peak near 27 Hz. The other lines of the data set stand beside it."""
    frequency, damping, _ = locked_modes(full)
    assert frequency[:4] == pytest.approx([15.7, 16.8, 27.9, 34.3], rel=0.01)
    assert damping[[0, 2]] == pytest.approx([0.016, 0.025], abs=0.001)


@pytest.mark.parametrize("mode", [0, 2])
def test_a_spring_that_decays_keeps_its_damping(full, mode):
    """Plucked along one mode with the brakes on: integration adds no damping of its own."""
    frequency, damping, shapes = locked_modes(full)
    mj = load_model(assets.IRB1400_XML).mj
    mj.opt.gravity[:] = 0.0
    data = mujoco.MjData(mj)
    for i in AXES:
        data.eq_active[mj.eq(f"brake_{i}").id] = 1
    shape = shapes[:, mode]
    data.qpos[:] = 1e-5 * shape / np.abs(shape).max()
    n = round(12.0 / frequency[mode] / mj.opt.timestep)
    history = np.empty((n, mj.nq))
    for i in range(n):
        mujoco.mj_step(mj, data)
        history[i] = data.qpos
    swing = history[:, np.argmax(np.abs(shape))]
    peaks = np.flatnonzero((swing[1:-1] > swing[:-2]) & (swing[1:-1] > swing[2:])) + 1
    rate = -np.polyfit(peaks * mj.opt.timestep, np.log(swing[peaks]), 1)[0]
    measured = rate / (2 * np.pi * frequency[mode])
    assert measured == pytest.approx(damping[mode], rel=0.03)


def test_the_springs_balance_170_nm_times_sine_of_the_lower_arm(full):
    for phi_2 in (-1.0, 0.3, 1.2):
        data = at_rest_pose(full, np.array([0.0, phi_2, phi_2, 0.0, 0.0, 0.0]))
        torque = data.qfrc_spring[full.flex[1]]
        assert torque == pytest.approx(-170.0 * np.sin(phi_2), abs=1e-9)


def test_it_starts_at_rest_under_its_own_weight(full):
    phi = np.array([0.3, 0.8, 0.2, 0.4, -0.5, 1.0])
    run = VirtualRobot(full).run(np.tile(phi, (50, 1)))
    assert np.ptp(run.truth.tool_position, axis=0).max() < 1e-6  # the solver's compliance settles
    assert np.abs(np.linalg.norm(run.truth.imu_acceleration, axis=1) - G).max() < 0.005


def test_brakes_hold_what_the_drives_let_go(full):
    """Motors off: no current, six brakes; the arm stays, where without brakes it would fall."""
    model = load_model(assets.IRB1400_XML)
    mujoco_model = model.mj
    mujoco_model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    phi = np.array([0.0, 0.6, 0.3, 0.0, 0.0, 0.0])
    start = at_rest_pose(model, phi).site("tool0").xpos
    assert np.linalg.norm(held(model, phi).site("tool0").xpos - start) < 1e-3
    loose = at_rest_pose(model, phi)
    for _ in range(500):
        mujoco.mj_step(mujoco_model, loose)
    assert np.linalg.norm(loose.site("tool0").xpos - start) > 5e-3


# Variants


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan])
def test_a_stiffness_factor_that_is_not_positive_is_refused(factor):
    with pytest.raises(ValueError, match="gear stiffness factor must be > 0"):
        variant(assets.IRB1400_XML, gear_stiffness=factor)


# The servo
