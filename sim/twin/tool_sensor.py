"""Sensors of the tool that a twin is identified from, and the laser tracker as one of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from armside.arrays import Array

from ..robot.model import RobotModel
from ..robot.recording import Recording
from .kinematic_columns import from_rest, gear_error_columns, jacobians, rigid_path
from .recordings import ImplausibleError, MeasuredCut
from .simulation import motor_path, tool_path

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
    check: Callable[[RobotModel, MeasuredCut], None]
    """Raises ImplausibleError for a cut without this sensor, or against the nominal robot."""
    comparison: Callable[[RobotModel, MeasuredCut], CutComparison]
    """Of a cut, which has this sensor, with runs of a design."""


def check_tracked(model: RobotModel, cut: MeasuredCut) -> None:
    """Raise ImplausibleError for a cut without a tracker, or against the nominal robot."""
    if cut.tool is None:
        raise ImplausibleError(f"{cut.name} has no samples of a laser tracker")
    if not np.isfinite(cut.tool).all():
        raise ImplausibleError(f"{cut.name}: tool holds values that are not finite")
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
        errors = gear_error_columns(self.model, self.cut.motor_angle, jacobian)
        position, orientation = np.split(from_rest(geometry), 2, axis=2)
        return {"gear_error": from_rest(errors), "position": position, "orientation": orientation}

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
