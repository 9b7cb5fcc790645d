"""The arm's motion from measured motor angles alone: the nominal arm dragged along, one rollout.

Exact where the nominal arm is: motor dynamics, friction and servo drop out, as the motor angles are
measured.
"""

import copy
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..robot.servo import interpolate, substeps
from .nominal import NominalArm

ENCODER_FILTER = 60.0
"""[Hz], zero-phase low-pass of the motor angles; far above the arm's modes, below the noise of
differences of encoder counts."""
LARGEST_STEP = 0.25
"""Period of the fastest mode in which the rollout takes a step at least. Semi-implicit Euler, which
integrates springs, grows without bound from 1 / pi on."""
_FULL_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
_NEWTON_STEPS = 200
_REST_TORQUE = 1e-7  # [N m]


@dataclass(frozen=True)
class ArmMotion:
    """Motion of the nominal arm. All rows belong to the same instant."""

    time: Array
    """(M,) [s], every physics step."""
    q: Array
    """(M, n) [rad], angles of the arm's free joints; q_dot (M, n) [rad/s]."""
    q_dot: Array
    tool_position: Array
    """(M, 3) [m], TCP0 in base axes."""
    tool_quaternion: Array
    """(M, 4), base to tool."""
    imu_acceleration: Array
    """(M, 3) [m/s^2], specific force in the frame of the IMU's site, as the rates [rad/s]."""
    imu_angular_velocity: Array


def at_rest(arm: NominalArm, phi: Array) -> Array:
    """(n,) [rad], the arm's free joints with its motors held at phi (a,).

    Raises RuntimeError when the springs cannot carry the arm.
    """
    motion = arm.motion
    mj, data = motion.mj, motion.data()
    q = np.zeros(arm.n_free)
    q[arm.axes] = phi
    data.ctrl[:] = arm.spring_input(phi, np.zeros_like(phi))
    spring = _spring_matrix(arm)
    for _ in range(_NEWTON_STEPS):
        motion.place(data, q)
        data.qvel[:] = data.qacc[:] = 0.0
        mujoco.mj_inverse(mj, data)
        mujoco.mj_fwdActuation(mj, data)
        missing = motion.forces(data, data.qfrc_inverse - data.qfrc_actuator)
        if np.abs(missing).max() < _REST_TORQUE:
            return q
        q -= np.linalg.solve(spring, missing)
    raise RuntimeError(f"no static equilibrium at motor angles {np.round(phi, 4).tolist()}")


def _spring_matrix(arm: NominalArm) -> Array:
    """(n, n) [N m/rad], of gears and structure."""
    spring = np.diag(arm.mj.jnt_stiffness[arm.mj.dof_jntid][arm.motion.joints])
    spring[arm.axes, arm.axes] += arm.stiffness
    return spring


def fastest_mode(arm: NominalArm, q: Array) -> float:
    """Highest natural frequency [Hz] of the arm at its angles q (n,), motors held."""
    motion = arm.motion
    data = motion.data()
    motion.place(data, q)
    mujoco.mj_forward(motion.mj, data)
    square = np.linalg.eigvals(np.linalg.solve(motion.mass(data), _spring_matrix(arm))).real
    return float(np.sqrt(max(square.max(), 0.0))) / (2.0 * np.pi)


def integrable(arm: NominalArm, q: Array) -> NominalArm:
    """The arm with a step that carries its fastest mode: its own, or a whole fraction of it.

    Springs that are identified with a light tool can have a mode above what the robot's step does.
    """
    step = float(arm.mj.opt.timestep)
    fraction = int(np.ceil(step * fastest_mode(arm, q) / LARGEST_STEP))
    if fraction <= 1:
        return arm
    mj = copy.copy(arm.mj)
    mj.opt.timestep = step / fraction
    return replace(arm, mj=mj)


def observe(arm: NominalArm, motor_angle: Array, period: float) -> ArmMotion:
    """The arm's motion from logged motor angles (N, a) [rad], every `period` [s].

    The log is low-passed without phase and splined to the physics rate; it starts at rest.
    """
    smooth = arm.gear_output(ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle))
    arm = integrable(arm, at_rest(arm, smooth[0]))
    phi, phi_dot, _ = interpolate(smooth, period, substeps(float(arm.mj.opt.timestep), period))
    return dragged(arm, phi, phi_dot)


def dragged(arm: NominalArm, phi: Array, phi_dot: Array) -> ArmMotion:
    """The arm's motion from motor angles and rates (M, a) at every physics step."""
    mj = arm.mj
    data = mujoco.MjData(mj)
    arm.motion.place(data, at_rest(arm, phi[0]))
    initial = np.empty(mujoco.mj_stateSize(mj, int(_FULL_STATE)))
    mujoco.mj_getState(mj, data, initial, int(_FULL_STATE))
    controls = arm.spring_input(phi, phi_dot)
    with Rollout(nthread=0) as rollout:
        result = rollout.rollout([mj], [data], initial[None], controls[None])
    states, sensors = (np.asarray(part, dtype=np.float64)[0] for part in result)
    moved = np.vstack((initial, states[:-1]))  # a state row belongs to the end of its step
    free = 1 + arm.motion.joints

    def sensor(name: str) -> Array:
        adr, dim = int(mj.sensor(name).adr[0]), int(mj.sensor(name).dim[0])
        return sensors[:, adr : adr + dim]

    time = np.arange(len(phi), dtype=np.float64) * float(mj.opt.timestep)
    tool, imu = (sensor("tool0_pos"), sensor("tool0_quat")), (sensor("imu_acc"), sensor("imu_gyro"))
    return ArmMotion(time, moved[:, free], moved[:, mj.nq + free], *tool, *imu)
