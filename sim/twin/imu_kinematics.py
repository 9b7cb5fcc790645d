"""Readings of an ideal IMU at the tool from kinematics, every spring at zero.

    f = R^T (p'' - g)        a change:  df = R^T (dp'' - dtheta x (p'' - g)),   dw = R^T dtheta'

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
    turning: Array
    """(N, 3) [rad/s], base axes."""

    @property
    def reading(self) -> Array:
        """(N, 6): specific force [m/s^2] and angular velocity [rad/s], in the housing's axes."""
        return self._housing(self.force, self.turning)

    def change(self, moved: Array) -> Array:
        """(N, 6, ...), change of the reading by displacements and rotations (N, 6, ...)."""
        rotation = moved[:, 3:]
        rate = np.gradient(moved, self.period, axis=0)
        pulled = np.gradient(rate[:, :3], self.period, axis=0)
        tilted = np.einsum("abc,kb...,kc->ka...", _CROSS, rotation, self.force)
        return self._housing(pulled - tilted, rate[:, 3:])

    def _housing(self, force: Array, turning: Array) -> Array:
        parts = [np.einsum("kba,kb...->ka...", self.R_base_imu, v) for v in (force, turning)]
        return np.concatenate(parts, axis=1)


_CROSS = np.zeros((3, 3, 3))
for _i in range(3):
    _CROSS[_i, (_i + 1) % 3, (_i + 2) % 3] = 1.0
    _CROSS[_i, (_i + 2) % 3, (_i + 1) % 3] = -1.0


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
    rate = np.gradient(phi, period, axis=0)
    turning = np.einsum("kij,kj->ki", jacobian[:, 3:], rate)
    pulled = np.gradient(np.gradient(position, period, axis=0), period, axis=0)
    return ImuKinematics(period, jacobian, rotation, pulled - mj.opt.gravity, turning)
