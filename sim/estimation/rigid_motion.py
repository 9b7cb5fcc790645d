"""The motion of an arm whose springs do not give way, and what its elastic hinges take from it.

Everything here follows from the measured motor angles and from masses; no spring enters.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..robot.linkage import FreeMotion
from ..robot.model import RobotModel
from ..robot.servo import interpolate
from .arm_filter import TWIST
from .elasticity import Elasticity
from .linearised_arm import LinearisedArm, forward, imu_kinematics, matrices
from .nominal import NominalArm

ENCODER_FILTER = 60.0
"""[Hz], zero-phase low-pass of the motor angles; far above the arm's modes, below the noise of
differences of encoder counts."""
REACH = 0.03
"""Largest change of a motor angle within which matrices are taken to be constant [rad]."""


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rigid arm along logged motor angles. n elastic degrees of freedom: gears and structure."""

    arm: NominalArm
    time: Array
    """(N,) [s]."""
    phi: Array
    """(N, a) [rad], motor angles, low-passed, less the transmission error that is known."""
    load: Array
    """(N, n) [N m] on the springs."""
    reading: Array
    """(N, 6) [m/s^2], [rad/s], of an ideal IMU."""
    imu_jacobian: Array
    """(N, 6, n), (v, omega) in the axes of the IMU."""
    imu_gravity: Array
    """(N, 3, n) [m/s^2/rad], change of gravity in the IMU's axes by tilting."""
    up: Array
    """(N, 3) [m/s^2], reading of an ideal accelerometer that does not move."""
    segment: np.ndarray
    """(N,) index of the segment with constant matrices."""
    mass: Array
    """(S, n, n) [kg m^2] of each segment."""
    gradient: Array
    """(S, n, n) [N m/rad], of gravity and passive forces."""
    middle: np.ndarray
    """(S,) sample at which a segment's matrices are taken."""

    @property
    def period(self) -> float:
        return float(self.time[1] - self.time[0])

    def linearised(self, segment: int, springs: Elasticity) -> LinearisedArm:
        """The arm on springs, in one segment."""
        at, gears = int(self.middle[segment]), springs.axes
        if segment not in self._postures:
            arm, q = self.arm, _posture(self.arm, self.phi[at])
            data = arm.motion.data()
            forward(arm.motion, data, q)
            jacobian = arm.motion.jacobian(data, arm.mj.site("tool0").id)
            self._postures[segment] = q, jacobian
        q, tool_jacobian = self._postures[segment]
        structure, damping = springs.stiffness.copy(), springs.damping.copy()
        structure[gears] = damping[gears] = 0.0
        return LinearisedArm(
            q=q,
            mass=self.mass[segment],
            gradient=self.gradient[segment] + np.diag(structure),
            structure_damping=damping,
            axes=gears,
            stiffness=springs.stiffness[gears],
            damping=springs.damping[gears],
            tool_jacobian=tool_jacobian,
            imu_jacobian=self.imu_jacobian[at],
            imu_gravity=self.imu_gravity[at],
        )

    @cached_property
    def _postures(self) -> dict[int, tuple[Array, Array]]:
        """Angles and the tool's Jacobian, by segment; no spring changes them."""
        return {}

    def excitation(self, robot: RobotModel) -> float:
        """Largest RMS twist of a gear by inertia, over `TWIST`, on the springs of the robot's file.

        Gravity is left out: along a large path it changes however slow the motion is.
        """
        q = _posture(self.arm, self.phi)
        still, _ = inverse_dynamics(self.arm.motion, q, 0.0 * q, 0.0 * q)
        gears = [robot.mj.joint(f"flex_{i + 1}").stiffness[0] for i in range(robot.n_axes)]
        twist = (self.load - still)[:, self.arm.axes] / gears
        return float(np.sqrt(np.square(twist).mean(axis=0)).max()) / TWIST

    def beginning(self, seconds: float) -> "RigidMotion":
        """Its first seconds."""
        n = int(np.searchsorted(self.time, seconds))
        names = ("time", "phi", "load", "reading", "imu_jacobian", "imu_gravity", "up", "segment")
        return replace(self, **{name: getattr(self, name)[:n] for name in names})


def rigid_motion(arm: NominalArm, time: Array, motor_angle: Array) -> RigidMotion:
    """Of a log (N,), (N, a). Springs of the arm do not matter."""
    period = float(time[1] - time[0])
    smooth = ZeroPhaseButterworth(ENCODER_FILTER, period)(motor_angle)
    phi, phi_dot, phi_ddot = interpolate(arm.gear_output(smooth), period, 1)
    q, q_dot, q_ddot = (_posture(arm, each) for each in (phi, phi_dot, phi_ddot))
    q_dot[0] = q_ddot[0] = 0.0  # a run starts at rest, where differences of counts are noise
    load, reading = inverse_dynamics(arm.motion, q, q_dot, q_ddot)
    J, tilt, up = imu_kinematics(arm.motion, q)
    segment = segments(phi)
    middle = np.array([int(np.flatnonzero(segment == s).mean()) for s in range(segment[-1] + 1)])
    mass, gradient = matrices(arm.motion, q[middle])
    gradient -= np.diag(arm.mj.jnt_stiffness.ravel()[arm.motion.joints])
    series = (time, phi, load, reading, J, tilt, up, segment)
    return RigidMotion(arm, *series, mass, gradient, middle)


def inverse_dynamics(
    motion: FreeMotion, q: Array, q_dot: Array, q_ddot: Array
) -> tuple[Array, Array]:
    """Torques (N, n) that motions take, gear springs left out, and readings (N, 6) of the IMU."""
    mj, data = motion.mj, motion.data()
    sensors = [mj.sensor(name).adr[0] + np.arange(3) for name in ("imu_acc", "imu_gyro")]
    picked = np.concatenate(sensors)
    torque, reading = np.empty_like(q), np.empty((len(q), 6))
    for i in range(len(q)):
        motion.move(data, q[i], q_dot[i], q_ddot[i])
        mujoco.mj_inverse(mj, data)
        torque[i], reading[i] = motion.forces(data, data.qfrc_inverse), data.sensordata[picked]
    return torque, reading


def segments(phi: Array, reach: float = REACH) -> np.ndarray:
    """(N,) index, ascending: a segment ends where an angle (N, a) has changed by `reach` [rad]."""
    index, first, count = np.zeros(len(phi), dtype=np.int64), phi[0], 0
    for i, now in enumerate(phi):
        if np.abs(now - first).max() > reach:
            first, count = now, count + 1
        index[i] = count
    return index


def _posture(arm: NominalArm, phi: Array) -> Array:
    q = np.zeros((*phi.shape[:-1], arm.n_free))
    q[..., arm.axes] = phi
    return q
