"""Sensitivities of the tool's path and of an IMU's reading from kinematics, every spring at zero.

They are quasi-static: what a transmission error of a few hertz excites in the springs is left to
the simulation of the twin, whose residual the next step sees. Specific force at the site `imu`:

    f = R^T (p'' - g)        a change:  df = R^T (dp'' - dtheta x (p'' - g))

with the displacement dp and the small rotation dtheta of the housing, in base axes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from armside.arrays import Array

from ..estimation.relative_path import REST_SAMPLES
from ..robot.effects import gear_orders
from ..robot.mjcf import AXES, N_AXES
from ..robot.model import RobotModel


def _configurations(model: RobotModel, phi: Array) -> Iterator[tuple[int, mujoco.MjData]]:
    """Number and rigid kinematics of each configuration phi (N, 6) [rad]; the data are reused."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    for k, q in enumerate(phi @ model.posture.T):
        data.qpos[:] = q
        mujoco.mj_kinematics(mj, data)
        mujoco.mj_comPos(mj, data)
        yield k, data


def jacobians(model: RobotModel, phi: Array) -> tuple[Array, Array]:
    """Jacobian (N, 3, 6) of the tool's position, and columns (N, 3, 36) of geometry errors.

    phi: (N, 6) [rad], motor angles. Geometry: positions (6, 3) [m] in the
    axes of the parent, orientations (6, 3) [rad] in those of the body, as in `Individual`.
    """
    mj, site = model.mj, model.mj.site("tool0").id
    bodies = [int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id]) for i in AXES]
    jacobian, out = np.empty((3, mj.nv)), np.empty((len(phi), 3, N_AXES))
    geometry = np.empty((len(phi), 3, 2 * N_AXES, 3))
    for k, data in _configurations(model, phi):
        mujoco.mj_jacSite(mj, data, jacobian, None, site)
        out[k] = jacobian[:, model.motor]
        tool = data.site_xpos[site]
        for j, body in enumerate(bodies):
            # Rotated before the body's own joints act: in axes of the parent times body_quat.
            parent = data.xmat[mj.body_parentid[body]].reshape(3, 3)
            rest = np.empty(9)
            mujoco.mju_quat2Mat(rest, mj.body_quat[body])
            turned = parent @ rest.reshape(3, 3)
            origin = data.xpos[mj.body_parentid[body]] + parent @ mj.body_pos[body]
            geometry[k, :, j] = parent
            geometry[k, :, N_AXES + j] = np.cross(turned.T, tool - origin).T
    return out, geometry.reshape(len(phi), 3, -1)


def rigid_path(model: RobotModel, phi: Array) -> Array:
    """(N, 3) [m], tool of the rigid robot in base axes at motor angles (N, 6) [rad]."""
    site, path = model.mj.site("tool0").id, np.empty((len(phi), 3))
    for k, data in _configurations(model, phi):
        path[k] = data.site_xpos[site]
    return path


def gear_waves(model: RobotModel, phi: Array) -> Array:
    """(N, 6, 4, 2) [rad]: (sine, cosine) of each axis and order at motor angles phi (N, 6) [rad].

    Of the amplitudes of the design.
    """
    amplitude, order = gear_orders(model)
    angle = order * phi[:, :, None]
    return amplitude[..., None] * np.stack((np.sin(angle), np.cos(angle)), axis=-1)


def gear_error_columns(model: RobotModel, phi: Array, jacobian: Array) -> Array:
    """(N, 3, 6 * 4 * 2): tool displacement [m] for (sine, cosine) of each axis and order.

    Relative to the amplitudes of the design.
    """
    waves = gear_waves(model, phi)
    return (jacobian[:, :, :, None, None] * waves[:, None]).reshape(len(phi), 3, -1)


def from_rest(columns: Array) -> Array:
    """Columns (N, ...) less their mean at rest, before the arm moves."""
    return columns - columns[:REST_SAMPLES].mean(axis=0)


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
    mj, site, n = model.mj, model.mj.site("imu").id, len(phi)
    jacobian, position, rotation = np.empty((n, 6, 6)), np.empty((n, 3)), np.empty((n, 3, 3))
    whole = np.empty((6, mj.nv))
    for k, data in _configurations(model, phi):
        mujoco.mj_jacSite(mj, data, whole[:3], whole[3:], site)
        jacobian[k] = whole[:, model.motor]
        position[k] = data.site_xpos[site]
        rotation[k] = data.site_xmat[site].reshape(3, 3)
    pulled = np.gradient(np.gradient(position, period, axis=0), period, axis=0)
    return ImuKinematics(period, jacobian, rotation, pulled - mj.opt.gravity)
