"""Health check of IMU samples: faults by name, and repair of single samples.

Single lost or clipped samples become rows of NaN on an even timeline, which filters predict over.
Too many of them are a fault, as are constant readings and timestamps out of order.
"""

from enum import Enum

import numpy as np

from ..instruments.imu import ImuCfg, ImuSamples

REST = 0.2
"""At the beginning of a run in which the arm does not move yet [s]."""
MOST_MISSING = 0.2  # Fraction of samples that may be lost or clipped. ESTIMATE.
_LATE = 0.25  # of a period, by which a sample may be off its place


class Fault(Enum):
    """Fault for which an IMU cannot be used."""

    TOO_SHORT = "too few samples"
    OUT_OF_ORDER = "timestamps out of order"
    UNEVEN = "timestamps off the unit's rate"
    NOT_FINITE = "readings that are not finite"
    DEAD = "dead sensor"
    CLIPPED = "clipped readings"
    LOST = "lost samples"
    MODEL = "a model that does not explain the readings"


class ImuError(ValueError):
    """An IMU that cannot be used, with its fault."""

    def __init__(self, fault: Fault, details: str) -> None:
        super().__init__(f"IMU: {fault.value}: {details}")
        self.fault, self.details = fault, details

    def __reduce__(self) -> tuple[type, tuple[Fault, str]]:
        return type(self), (self.fault, self.details)


def repaired(samples: ImuSamples, cfg: ImuCfg) -> ImuSamples:
    """The samples on an even timeline, NaN where one is lost or clipped.

    Raises:
        ImuError: they cannot be used; says what is wrong, where and by how much.
    """
    time = samples.time
    if len(time) < 2 or time[-1] - time[0] < 0.5:
        raise ImuError(Fault.TOO_SHORT, f"{len(time)} samples; half a second is needed")
    backwards = np.flatnonzero(np.diff(time) <= 0.0)
    if len(backwards):
        i = int(backwards[0])
        raise ImuError(Fault.OUT_OF_ORDER, f"{time[i + 1]:.4f} s follows {time[i]:.4f} s")
    place = (time - time[0]) * cfg.rate
    slot = np.rint(place).astype(int)
    off = np.abs(place - slot)
    if off.max() > _LATE or len(np.unique(slot)) < len(slot):
        i = int(np.argmax(off))
        raise ImuError(Fault.UNEVEN, f"{time[i]:.4f} s does not fit {cfg.rate:g} Hz")
    reading = np.hstack((samples.acceleration, samples.angular_velocity))
    if not np.isfinite(reading).all():
        i = int(np.argmin(np.isfinite(reading).all(axis=1)))
        raise ImuError(Fault.NOT_FINITE, f"at {time[i]:.4f} s")
    still = np.ptp(reading, axis=0) == 0.0
    if still.any():
        raise ImuError(Fault.DEAD, f"{', '.join(_CHANNELS[i] for i in np.flatnonzero(still))}")
    clipped = np.hstack((samples.acceleration_clipped, samples.angular_velocity_clipped))
    _few(np.asarray(clipped.any(axis=1)), Fault.CLIPPED)
    n = int(slot[-1]) + 1
    lost = np.ones(n, dtype=bool)
    lost[slot] = False
    _few(lost, Fault.LOST)
    reading[clipped.any(axis=1)] = np.nan
    whole = np.full((n, 6), np.nan)
    whole[slot] = reading
    return ImuSamples(
        time=time[0] + np.arange(n) / cfg.rate,
        acceleration=whole[:, :3],
        angular_velocity=whole[:, 3:],
        acceleration_clipped=np.zeros((n, 3), dtype=bool),
        angular_velocity_clipped=np.zeros((n, 3), dtype=bool),
    )


_CHANNELS = (*(f"accelerometer {c}" for c in "xyz"), *(f"gyro {c}" for c in "xyz"))


def _few(missing: np.ndarray, fault: Fault) -> None:
    fraction = float(missing.mean())
    if fraction > MOST_MISSING:
        most = f"{100 * MOST_MISSING:.0f} % at most"
        raise ImuError(fault, f"{100 * fraction:.0f} % of the samples, {most}")
