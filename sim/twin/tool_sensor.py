"""Sensors of the tool that a twin is identified from: their residuals, as the solver takes them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from armside.arrays import Array

from ..robot.model import RobotModel
from ..robot.recording import Recording
from .measured import MeasuredCut


@dataclass(frozen=True)
class Channels:
    """Columns of a residual that share a scale."""

    columns: slice
    noise: float
    """Least scale, in the unit of the residual."""
    correlation: float
    """Scale over root mean square: square root of samples over independent samples."""


class Comparison(Protocol):
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


@dataclass(frozen=True)
class Scale:
    """Scale that residuals of a sensor are shown on."""

    quantity: str
    unit: str
    factor: float
    """Shown value over that of the residual."""
    displacement: float
    """Displacement of the tool [m] that a residual of one stands for."""
    unsuspicious: float
    """Residual below which no cut is called corrupt. ESTIMATE."""


class ToolSensor(Protocol):
    """Kind of sensor at the tool."""

    @property
    def scale(self) -> Scale: ...

    @property
    def channels(self) -> tuple[Channels, ...]:
        """Groups of the columns of residuals."""
        ...

    def check(self, model: RobotModel, cut: MeasuredCut) -> None:
        """Raise ImplausibleError for a cut without this sensor, or against the nominal robot."""
        ...

    def comparison(self, model: RobotModel, cut: MeasuredCut) -> Comparison:
        """Comparison of a cut, which has this sensor, with runs of a design."""
        ...
