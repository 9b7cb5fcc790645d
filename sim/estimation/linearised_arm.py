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
from .observer import at_rest

_TURN = 1e-6  # [rad], of the differences that gradients are made of


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
    imu_up: Array
    """(3,) [m/s^2], reading of an ideal accelerometer at rest."""

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
    mj, data = motion.mj, motion.data()
    motion.place(data, q)
    mujoco.mj_forward(mj, data)
    tool, imu = mj.site("tool0").id, mj.site("imu").id
    J_tool, J_imu = motion.jacobian(data, tool), motion.jacobian(data, imu)
    R_imu_base = data.site_xmat[imu].reshape(3, 3).T
    J_imu = np.vstack((R_imu_base @ J_imu[:3], R_imu_base @ J_imu[3:]))
    gradient, tilt = _gradients(motion, q, imu)
    passive = mj.dof_damping[motion.joints]
    springs = arm.axes, arm.stiffness, arm.damping
    up = -R_imu_base @ mj.opt.gravity
    mass = motion.mass(data)
    return LinearisedArm(q, mass, gradient, passive, *springs, J_tool, J_imu, tilt, up)


def _gradients(motion: FreeMotion, q: Array, imu: int) -> tuple[Array, Array]:
    """Central differences of the passive and gravity forces, and of gravity in the IMU's axes."""
    mj, data = motion.mj, motion.data()

    def at(moved: Array) -> tuple[Array, Array]:
        motion.place(data, moved)
        mujoco.mj_forward(mj, data)
        up = -data.site_xmat[imu].reshape(3, 3).T @ mj.opt.gravity
        return motion.forces(data, data.qfrc_bias - data.qfrc_passive), up

    force, up = np.empty((len(q), len(q))), np.empty((3, len(q)))
    for i, turn in enumerate(_TURN * np.eye(len(q))):
        (f1, u1), (f0, u0) = at(q + turn), at(q - turn)
        force[:, i], up[:, i] = (f1 - f0) / (2.0 * _TURN), (u1 - u0) / (2.0 * _TURN)
    return force, up
