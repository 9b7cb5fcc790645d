"""The nominal arm linearised at rest in one pose: the model of filters and laws.

    M dq'' + (S D S^T + D_s) dq' + (S K S^T + G) dq = S (K dphi + D dphi')

dq and dphi are deviations of arm and motors, S picks the axes among the arm's free joints, G is the
gradient of gravity and of springs that are not gears. Over hundredths of a radian the matrices are
constant.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from ..robot.linkage import FreeMotion
from .nominal import NominalArm

_TURN = 1e-6  # [rad], of the differences that gradients are made of
_NEWTON_STEPS = 200
_REST_TORQUE = 1e-7  # [N m]


@dataclass(frozen=True, eq=False)
class LinearisedArm:
    """Matrices of the arm at rest. n degrees of freedom, a of them behind gears."""

    q: Array
    """(n,) [rad], the arm's angles at rest."""
    mass: Array
    """(n, n) [kg m^2]."""
    gradient: Array
    """G, (n, n) [N m/rad]."""
    structure_damping: Array
    """(n,) diagonal of D_s [N m s/rad]."""
    axes: np.ndarray
    """(a,) the degrees of freedom behind gears."""
    stiffness: Array
    """Diagonal of K, (a,) [N m/rad]."""
    damping: Array
    """D, (a,) [N m s/rad]."""
    tool_jacobian: Array
    """(6, n), (v, omega) of TCP0 in base axes."""
    imu_jacobian: Array
    """(6, n), (v, omega) of the IMU in its own axes."""
    imu_gravity: Array
    """(3, n) [m/s^2/rad], change of gravity in the IMU's axes by tilting."""

    @property
    def n_free(self) -> int:
        return len(self.mass)

    @property
    def spring_matrix(self) -> Array:
        """S K S^T + G."""
        K = self.gradient.copy()
        K[self.axes, self.axes] += self.stiffness
        return K

    @property
    def damping_matrix(self) -> Array:
        """S D S^T + D_s."""
        D = np.diag(self.structure_damping)
        D[self.axes, self.axes] += self.damping
        return D

    def dynamics(self) -> tuple[Array, Array]:
        """A (2n, 2n) and B (2n, 2a) of x' = A x + B (dphi, dphi'), x = (dq, dq')."""
        n, n_axes = self.n_free, len(self.axes)
        picked = np.zeros((n, n_axes))
        picked[self.axes, range(n_axes)] = 1.0
        state = -self.spring_matrix, -self.damping_matrix
        motors = picked * self.stiffness, picked * self.damping
        acceleration = np.linalg.solve(self.mass, np.hstack((*state, *motors)))
        A, B = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n_axes))
        A[:n, n:] = np.eye(n)
        A[n:], B[n:] = np.split(acceleration, [2 * n], axis=1)
        return A, B

    def locked_modes(self) -> Array:
        """(n,) [Hz], ascending: natural frequencies with the motors held."""
        square = np.linalg.eigvals(np.linalg.solve(self.mass, self.spring_matrix))
        return np.sort(np.sqrt(np.maximum(square.real, 0.0))) / (2.0 * np.pi)


def linearised(arm: NominalArm, phi: Array) -> LinearisedArm:
    """The arm at rest with its motors at phi, (a,) [rad]."""
    motion, q = arm.motion, at_rest(arm, phi)
    data = motion.data()
    forward(motion, data, q)
    tool = motion.jacobian(data, motion.mj.site("tool0").id)
    (J_imu,), (tilt,), _ = imu_kinematics(motion, q[None])
    (mass,), (gradient,) = matrices(motion, q[None])
    passive = motion.mj.dof_damping[motion.joints]
    springs = arm.axes, arm.stiffness, arm.damping
    return LinearisedArm(q, mass, gradient, passive, *springs, tool, J_imu, tilt)


def at_rest(arm: NominalArm, phi: Array) -> Array:
    """(n,) [rad], the free joints with the motors held at phi (a,). Raises RuntimeError when the
    springs cannot carry the arm."""
    motion = arm.motion
    mj, data = motion.mj, motion.data()
    q = np.zeros(arm.n_free)
    q[arm.axes] = phi
    data.ctrl[:] = phi
    spring = np.diag(arm.mj.jnt_stiffness[arm.mj.dof_jntid][motion.joints])
    spring[arm.axes, arm.axes] += arm.stiffness
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


def forward(motion: FreeMotion, data: mujoco.MjData, q: Array) -> None:
    """Put the arm at q (n,) and compute all that follows from it."""
    motion.place(data, q)
    mujoco.mj_forward(motion.mj, data)


def imu_kinematics(motion: FreeMotion, q: Array) -> tuple[Array, Array, Array]:
    """Jacobian (N, 6, n), gravity by tilting (N, 3, n) as of `LinearisedArm`, and reading at rest
    (N, 3) [m/s^2] of the IMU at q (N, n)."""
    mj, data = motion.mj, motion.data()
    site = mj.site("imu").id
    J, up = np.empty((len(q), 6, q.shape[1])), np.empty((len(q), 3))
    for i, angles in enumerate(q):
        motion.place(data, angles)
        mujoco.mj_fwdPosition(mj, data)
        in_base = motion.jacobian(data, site)
        R = data.site_xmat[site].reshape(3, 3).T
        J[i, :3], J[i, 3:] = R @ in_base[:3], R @ in_base[3:]
        up[i] = -R @ mj.opt.gravity
    tilt = np.cross(up[:, :, None], J[:, 3:], axis=1)  # gravity turns against the unit
    return J, np.ascontiguousarray(tilt), up


def matrices(motion: FreeMotion, postures: Array) -> tuple[Array, Array]:
    """Masses, and gradients of gravity and passive forces, (S, n, n) each, at (S, n)."""
    data, n = motion.data(), postures.shape[1]
    mass, gradient = np.empty((2, len(postures), n, n))

    def force(q: Array) -> Array:
        forward(motion, data, q)
        return motion.forces(data, data.qfrc_bias - data.qfrc_passive)

    for at, q in enumerate(postures):
        for i, turn in enumerate(_TURN * np.eye(n)):
            gradient[at, :, i] = (force(q + turn) - force(q - turn)) / (2.0 * _TURN)
        forward(motion, data, q)
        mass[at] = motion.mass(data)
    return mass, gradient
