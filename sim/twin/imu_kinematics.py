"""Specific force at the site `imu` from kinematics, every spring at zero.

    f = R^T (p'' - g)        a change:  df = R^T (dp'' - dtheta x (p'' - g))

with the displacement dp and the small rotation dtheta of the housing, in base axes.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from ..robot.model import RobotModel


@dataclass(frozen=True, eq=False)
class ImuKinematics:
    """Motion of the housing along a path of motor angles."""

    period: float
    """[s]."""
    jacobian: Array
    """(N, 6, 6), displacement [m] and rotation [rad] by motor angles."""
    R_base_imu: Array
    """(N, 3, 3)."""
    force: Array
    """(N, 3) [m/s^2], p'' - g, base axes."""

    @property
    def reading(self) -> Array:
        """(N, 3) [m/s^2], specific force in the housing's axes."""
        return self._in_housing(self.force)

    def change(self, phi: Array) -> Array:
        """(N, 3, ...) [m/s^2], change of the reading by motor angles (N, 6, ...) [rad]."""
        moved = np.einsum("kij,kj...->ki...", self.jacobian, phi)
        rate = np.gradient(moved[:, :3], self.period, axis=0)
        force = self.force.reshape(*self.force.shape, *[1] * (moved.ndim - 2))
        tilted = np.cross(moved[:, 3:], force, axis=1)
        return self._in_housing(np.gradient(rate, self.period, axis=0) - tilted)

    def _in_housing(self, vector: Array) -> Array:
        return np.asarray(np.einsum("kba,kb...->ka...", self.R_base_imu, vector))


def imu_kinematics(model: RobotModel, phi: Array, period: float) -> ImuKinematics:
    """Kinematics of the site `imu` along smooth motor angles phi (N, 6) [rad]."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    site = mj.site("imu").id
    n = len(phi)
    jacobian, position, rotation = np.empty((n, 6, 6)), np.empty((n, 3)), np.empty((n, 3, 3))
    whole = np.empty((6, mj.nv))
    for k, q in enumerate(phi @ model.posture.T):
        data.qpos[:] = q
        mujoco.mj_kinematics(mj, data)
        mujoco.mj_comPos(mj, data)
        mujoco.mj_jacSite(mj, data, whole[:3], whole[3:], site)
        jacobian[k] = whole[:, model.motor]
        position[k] = data.site_xpos[site]
        rotation[k] = data.site_xmat[site].reshape(3, 3)
    pulled = np.gradient(np.gradient(position, period, axis=0), period, axis=0)
    return ImuKinematics(period, jacobian, rotation, pulled - mj.opt.gravity)
