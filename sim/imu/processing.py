"""Choices of the signal processing of thesis 5.1."""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from ..instruments.imu import ACCELEROMETER, GYROSCOPE
from .prediction import Order, Scheme


class Compensation(Enum):
    """Compensation of the measurement for gravity and offsets."""

    MEAN_AT_REST = "mean-at-rest"
    """Gravity in base axes and the mean in the zero pose are subtracted. Thesis 5.1.1."""
    ACTUAL_ORIENTATION = "actual-orientation"
    """Mounting error and biases are fitted with the orientation of every sample, which the thesis
    names as future work."""


@dataclass(frozen=True, kw_only=True)
class ProcessingCfg:
    """Processing that makes measurement and prediction comparable."""

    cutoff: float = 5.0
    """Zero-phase second-order low-pass of both sides [Hz]. Thesis 5.1.1."""
    order: Order = Order.FILTER_THEN_MAP
    scheme: Scheme = Scheme.FORWARD
    compensation: Compensation = Compensation.ACTUAL_ORIENTATION
    accelerometer_delay: float = 1e-3 * round(1e3 * ACCELEROMETER.delay, 3)
    """Known delay of the sensor's own low-pass [s], to a microsecond; 0 leaves it in."""
    gyroscope_delay: float = 1e-3 * round(1e3 * GYROSCOPE.delay, 3)
    search: float = 0.5
    """Largest clock offset in the search [s]."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.cutoff) and self.cutoff > 0.0):
            raise ValueError(f"cutoff must be > 0 Hz, got {self.cutoff:g}")
        for name in ("accelerometer_delay", "gyroscope_delay"):
            delay = getattr(self, name)
            if not 0.0 <= delay <= self.search:
                most = f"from 0 to {1e3 * self.search:g} ms, the search of the clock offset"
                raise ValueError(f"{name} must be {most}, got {1e3 * delay:g}")

    @property
    def as_in_the_thesis(self) -> "ProcessingCfg":
        """Gravity by the mean at rest, and clocks synchronised by one sensor for both."""
        return replace(
            self, compensation=Compensation.MEAN_AT_REST, accelerometer_delay=self.gyroscope_delay
        )

    @property
    def best(self) -> "ProcessingCfg":
        """Both sides filtered alike, and no time shift between rate and angle."""
        return replace(self, order=Order.MAP_THEN_FILTER, scheme=Scheme.CENTRAL)
