"""Sensors of the tool that a twin is identified from, the laser tracker as one, and kinematics.

Sensitivities of the tool's path and of an IMU's reading from kinematics have every spring at zero.
They are quasi-static: what a transmission error of a few hertz excites in the springs is left to
the simulation of the twin, whose residual the next step sees. Specific force at the site `imu`:

    f = R^T (p'' - g)        a change:  df = R^T (dp'' - dtheta x (p'' - g))

with the displacement dp and the small rotation dtheta of the housing, in base axes.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import mujoco
import numpy as np

from armside.arrays import Array

from ..estimation.relative_path import REST_SAMPLES
from ..robot.effects import gear_orders
from ..robot.mjcf import AXES, N_AXES
from ..robot.model import RobotModel
from ..robot.recording import Recording
from .parameters import Block
from .recordings import ImplausibleError, MeasuredCut
from .simulation import motor_path, tool_path


def _configurations(model: RobotModel, phi: Array) -> Iterator[tuple[int, mujoco.MjData]]:
    """Number and rigid kinematics of each configuration phi (N, 6) [rad]; the data are reused."""
    mj, data = model.mj, mujoco.MjData(model.mj)
    for k, q in enumerate(phi @ model.posture.T):
        data.qpos[:] = q
        mujoco.mj_kinematics(mj, data)
        mujoco.mj_comPos(mj, data)
        yield k, data


def jacobians(model: RobotModel, phi: Array) -> tuple[Array, Array]:
    """Jacobian (N, 3, 6) of the tool's position at motor angles (N, 6) [rad], and columns (N, 3,
    36) of geometry errors: positions [m] and orientations [rad] as in `Individual`."""
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
    """(N, 6, 4, 2) [rad]: (sine, cosine) of each axis and order at motor angles phi (N, 6) [rad],
    of the amplitudes of the design."""
    amplitude, order = gear_orders(model)
    angle = order * phi[:, :, None]
    return amplitude[..., None] * np.stack((np.sin(angle), np.cos(angle)), axis=-1)


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
        return _rotated(self.R_base_imu, self.force)

    def change(self, phi: Array) -> Array:
        """(N, 3, ...) [m/s^2], change of the reading by motor angles (N, 6, ...) [rad]."""
        moved = np.einsum("kij,kj...->ki...", self.jacobian, phi)
        rate = np.gradient(moved[:, :3], self.period, axis=0)
        force = self.force.reshape(*self.force.shape, *[1] * (moved.ndim - 2))
        tilted = np.cross(moved[:, 3:], force, axis=1)
        return _rotated(self.R_base_imu, np.gradient(rate, self.period, axis=0) - tilted)


def _rotated(R_base_imu: Array, vector: Array) -> Array:
    return np.asarray(np.einsum("kba,kb...->ka...", R_base_imu, vector))


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


_LARGEST_OFFSET = 0.03
"""[m], of the tool at rest from the nominal robot: geometry and sag of an individual are a tenth of
it, a flange adapter is more. ESTIMATE."""
_LARGEST_PATH_ERROR = 2e-3
"""[m], of the tool's displacement from that of the motor angles: elasticity is a fifth of it."""


class CutComparison(Protocol):
    """One recorded cut as its tool sensor saw it, against simulations. C: all columns of it."""

    def residual(self, run: Recording) -> Array:
        """(K, C), measured less simulated, beyond what the motor angles explain."""
        ...

    def change(self, base: Recording, run: Recording) -> Array:
        """(K, C), reading of a run less that of another, beyond what the motor angles explain."""
        ...

    def by_kinematics(self) -> Mapping[str, Array]:
        """(K, C, m) for each block of parameters whose sensitivities need no simulation."""
        ...


@dataclass(frozen=True, kw_only=True)
class ToolSensor:
    """Kind of sensor at the tool, and the scale that its residuals are shown on."""

    noise: float
    """Least scale of residuals, in their unit."""
    correlation: float
    """Scale over root mean square: square root of samples over independent samples."""
    quantity: str
    unit: str
    factor: float
    """Shown value over that of the residual."""
    displacement: float
    """Displacement of the tool [m] that a residual of one stands for."""
    unsuspicious: float
    """Residual below which no cut is called corrupt. ESTIMATE."""
    check: Callable[[RobotModel, MeasuredCut, bool], None]
    """Raises ImplausibleError for a cut without this sensor, or, if told so, against the nominal
    robot."""
    comparison: Callable[[RobotModel, MeasuredCut], CutComparison]
    """Of a cut, which has this sensor, with runs of a design."""
    own: Callable[[MeasuredCut], tuple[Block, ...]] = lambda _: ()
    """What is unknown of the sensor itself, and shared by all cuts; columns by kinematics."""


def check_tracked(model: RobotModel, cut: MeasuredCut, against_nominal: bool = True) -> None:
    """Raise ImplausibleError for a cut without a tracker, or against the nominal robot."""
    if cut.tool is None:
        raise ImplausibleError(f"{cut.name} has no samples of a laser tracker")
    if not np.isfinite(cut.tool).all():
        raise ImplausibleError(f"{cut.name}: tool holds values that are not finite")
    if not against_nominal:
        return
    path = rigid_path(model, cut.motor_angle)
    off = float(np.abs(cut.tool - from_rest(path)).max())
    if off > _LARGEST_PATH_ERROR:
        raise ImplausibleError(
            f"{cut.name}: the tool is up to {1e3 * off:.3g} mm from where the motor angles put "
            "it: another robot, or another unit"
        )
    away = 0.0 if cut.rest is None else float(np.linalg.norm(cut.rest - path[0]))
    if away > _LARGEST_OFFSET:
        raise ImplausibleError(
            f"{cut.name}: the tool rests {1e3 * away:.3g} mm from where the nominal robot has "
            "it: another flange, or another base frame"
        )


@dataclass(frozen=True, eq=False)
class TrackerComparison:
    """See `CutComparison`."""

    model: RobotModel
    cut: MeasuredCut

    @cached_property
    def _kinematics(self) -> tuple[Array, Array]:
        return jacobians(self.model, self.cut.motor_angle)

    def residual(self, run: Recording) -> Array:
        assert self.cut.tool is not None
        moved = self._by_motors(self.cut.motor_angle - motor_path(run))
        return self.cut.tool - tool_path(run) - moved

    def change(self, base: Recording, run: Recording) -> Array:
        moved = self._by_motors(motor_path(run) - motor_path(base))
        return tool_path(run) - tool_path(base) - moved

    def by_kinematics(self) -> Mapping[str, Array]:
        jacobian, geometry = self._kinematics
        waves = gear_waves(self.model, self.cut.motor_angle)
        errors = jacobian[:, :, :, None, None] * waves[:, None]
        position, orientation = np.split(from_rest(geometry), 2, axis=2)
        errors = from_rest(errors.reshape(*jacobian.shape[:2], -1))
        return {"gear_error": errors, "position": position, "orientation": orientation}

    def _by_motors(self, moved: Array) -> Array:
        return from_rest(np.einsum("kij,kj->ki", self._kinematics[0], moved))


TRACKER = ToolSensor(
    noise=10e-6,
    correlation=3.0,  # What a model leaves of a path lasts for many samples. ESTIMATE.
    quantity="motion of the tool",
    unit="µm",
    factor=1e6,
    displacement=1.0,
    unsuspicious=100e-6,
    check=check_tracked,
    comparison=TrackerComparison,
)
"""Laser tracker; residuals are displacements from rest [m]."""
