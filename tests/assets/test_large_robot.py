"""The large robot's MJCF: what it weighs, where it is, and that it is the D-H robot."""

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh

from armside import assets, kinematics
from armside.sim.robot.model import load_model

# Both sides are products of a dozen rotations in double precision on lengths of a few metres.
SAME = 1e-12
# numbers in the file have eight decimals
FILE_DIGITS = 1e-7

# large-robot calibration: first four locked modes [Hz] and masses of the data set
LOCKED = {"p1": (7.1, 7.3, 11.8, 14.7), "p2": (6.1, 6.5, 12.5, 15.3), "p3": (5.5, 5.9, 13.5, 17.0)}
POSE_DEG = {
    "p1": (0, -18.9, 36.7, -5.4, -6.4, 11.1),
    "p2": (3.5, 7.8, 12.4, 18.2, -9.2, -11.6),
    "p3": (5.6, 29.9, -16.4, 67.6, -5.4, -60.7),
}


@pytest.fixture(scope="module")
def model():
    return load_model(assets.LARGE_ROBOT_XML)


@pytest.fixture
def data(model):
    return mujoco.MjData(model.mj)


def test_zero_pose_is_arm_up_forearm_forward(model, data):
    mujoco.mj_resetDataKeyframe(model.mj, data, model.mj.keyframe("zero").id)
    mujoco.mj_forward(model.mj, data)
    assert data.site("tool0").xpos == pytest.approx([0.320 + 1.142 + 0.200, 0, 0.780 + 1.075 + 0.2])
    imu_from_tool = data.site("imu").xpos - data.site("tool0").xpos
    assert imu_from_tool == pytest.approx([0.032, -0.026, 0.090])  # thesis 5.1.1
    assert data.site("imu").xmat == pytest.approx(np.eye(3).ravel())


def test_mjcf_and_denavit_hartenberg_agree_at_random_configurations(model, data):
    robot = kinematics.compile(kinematics.LARGE_ROBOT)
    rng = np.random.default_rng(1)
    jacobian = np.empty((6, model.mj.nv))
    for phi in rng.uniform(*model.joint_range.T, size=(50, 6)):
        data.qpos[:] = 0.0
        data.qpos[model.motor] = phi
        mujoco.mj_kinematics(model.mj, data)
        mujoco.mj_comPos(model.mj, data)
        site = data.site("tool0")
        mujoco.mj_jacSite(model.mj, data, jacobian[:3], jacobian[3:], site.id)
        T = robot.pose(phi)
        assert np.abs(T[:3, 3] - site.xpos).max() < SAME
        assert np.abs(T[:3, :3] - site.xmat.reshape(3, 3)).max() < SAME
        assert np.abs(robot.jacobian(phi) - jacobian[:, model.motor]).max() < SAME


def test_centres_of_mass_lie_in_their_links(model, data):
    """Inside the box around the geoms that are drawn for the link."""
    mujoco.mj_forward(model.mj, data)
    for i in range(1, model.mj.nbody):
        geoms = np.flatnonzero(model.mj.geom_bodyid == i)
        if not len(geoms):
            continue
        reach = model.mj.geom_rbound[geoms, None]
        low = (data.geom_xpos[geoms] - reach).min(axis=0)
        high = (data.geom_xpos[geoms] + reach).max(axis=0)
        assert (low <= data.xipos[i]).all(), model.mj.body(i).name
        assert (data.xipos[i] <= high).all(), model.mj.body(i).name


def test_servo_gains_follow_from_frequency_damping_and_inertia(model):
    """One damping ratio for all axes, and frequencies near those of the study."""
    frequency = np.array([6.5, 6.0, 3.8, 8.75, 10.8, 10.3])
    arm_inertia = np.array([700, 875, 268, 2.7, 9.5, 0.8])
    drives = model.drives
    inertia = model.mj.dof_armature[model.motor] + arm_inertia
    w0 = np.sqrt(drives.kp * drives.gear**2 / inertia)
    damping = drives.kd * drives.gear**2 / (2.0 * inertia * w0)
    assert damping == pytest.approx(np.full(6, damping[0]), rel=FILE_DIGITS)
    assert w0 / (2.0 * np.pi) == pytest.approx(frequency, rel=0.1)


def test_balancing_cylinder_pulls_as_its_spring(model, data):
    for q2, arm in ((np.deg2rad(30), 0.090), (np.deg2rad(60), 0.134), (0.0, 0.0)):
        data.qpos[:] = 0.0
        data.qpos[model.motor[1]] = q2
        mujoco.mj_forward(model.mj, data)
        length = data.ten_length[0]
        force = 24e3 + 100e3 * (length - 0.481)
        torque = -data.qfrc_spring[model.motor[1]]
        assert torque == pytest.approx(force * arm, abs=0.03 * 5e3)  # arms are given in mm


@pytest.mark.parametrize("pose", LOCKED)
def test_locked_modes_are_those_of_the_study(model, data, pose):
    """All motors held. Calibration moves stiffnesses by a few per cent, modes by half of that."""
    data.qpos[:] = 0.0
    data.qpos[model.motor] = np.deg2rad(POSE_DEG[pose])
    K = _stiffness(model, data)
    M = np.empty((model.mj.nv, model.mj.nv))
    mujoco.mj_forward(model.mj, data)
    mujoco.mj_fullM(model.mj, data, M)
    s = model.springs
    modes = np.sqrt(eigh(K[np.ix_(s, s)], M[np.ix_(s, s)], eigvals_only=True)) / (2 * np.pi)
    assert modes[:4] == pytest.approx(LOCKED[pose], rel=0.04)


def _stiffness(model, data, step=1e-6):
    """Derivative of the static force with respect to the joints: springs, gravity, cylinder."""
    K = np.empty((model.mj.nv, model.mj.nv))
    start = data.qpos.copy()
    for j in range(model.mj.nv):
        ends = []
        for sign in (1, -1):
            data.qpos[:] = start
            data.qpos[j] += sign * step
            data.qvel[:] = data.qacc[:] = 0.0
            mujoco.mj_inverse(model.mj, data)
            ends.append(data.qfrc_inverse.copy())
        K[:, j] = (ends[0] - ends[1]) / (2 * step)
    data.qpos[:] = start
    return K
