"""Motion of a model in the joints that its closed chains leave free.

The passive joints of a linkage follow the free ones q, so that the cuts stay closed:

    q_whole' = Z q'        q_whole'' = Z q'' + Z' q'        force = Z^T force_whole

Z is the linkage's tangent. Without cuts every joint is free and Z is the identity.
"""

import copy

import mujoco
import numpy as np

from armside.arrays import Array

from .linkage import Linkage, passive_joints


class FreeMotion:
    """Free joints of one model. Its data hold no forces of constraints."""

    def __init__(self, mj: mujoco.MjModel, follow: Array | None = None) -> None:
        """follow: (nv, n), joint angles from the n free ones, near which the linkage closes."""
        self.mj, self.linkage = mj, Linkage(mj)
        self.is_open, self.joints = self.linkage.is_open, free_joints(mj)
        if not self.is_open:
            self.mj = copy.copy(mj)
            self.mj.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self._follow = np.eye(mj.nv)[:, self.joints] if follow is None else follow

    def data(self) -> mujoco.MjData:
        """Scratch data for the methods below."""
        return mujoco.MjData(self.mj)

    def place(self, data: mujoco.MjData, q: Array) -> None:
        """Free joints at q, (n,) [rad]; passive ones close the cuts.

        Raises RuntimeError when they cannot be closed.
        """
        if self.is_open:
            data.qpos[:] = q
            return
        data.qpos[:] = self._follow @ q
        self.linkage.close(data)

    def move(self, data: mujoco.MjData, q: Array, q_dot: Array, q_ddot: Array) -> None:
        """Position, velocity and acceleration of all joints from those of the free, (n,) each."""
        self.place(data, q)
        if self.is_open:
            data.qvel[:], data.qacc[:] = q_dot, q_ddot
            return
        Z = self._tangent(data)
        data.qvel[:] = Z @ q_dot
        mujoco.mj_comVel(self.mj, data)
        data.qacc[:] = Z @ q_ddot + self.linkage.following_acceleration(data)

    def forces(self, data: mujoco.MjData, whole: Array) -> Array:
        """(n,) forces on the free joints of forces (nv,) on all of them, where data are placed."""
        return whole.copy() if self.is_open else self._tangent(data).T @ whole

    def mass(self, data: mujoco.MjData) -> Array:
        """(n, n) inertia of the free joints, after mj_forward."""
        M = np.empty((self.mj.nv, self.mj.nv))
        mujoco.mj_fullM(self.mj, data, M)
        if self.is_open:
            return M
        Z = self._tangent(data)
        return Z.T @ M @ Z

    def jacobian(self, data: mujoco.MjData, site: int) -> Array:
        """(6, n), (v, omega) of a site in base axes for the free joints' rates."""
        J = np.empty((6, self.mj.nv))
        mujoco.mj_jacSite(self.mj, data, J[:3], J[3:], site)
        return J if self.is_open else J @ self._tangent(data)

    def _tangent(self, data: mujoco.MjData) -> Array:
        return self.linkage.tangent(data)[:, self.joints]


def free_joints(mj: mujoco.MjModel) -> np.ndarray:
    """Degrees of freedom that closed chains leave free, ascending."""
    every = np.arange(mj.nv)
    return every if Linkage(mj).is_open else np.setdiff1d(every, passive_joints(mj))
