"""Judgement of a transmission error on a recording that it was not learned from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .aligned import EDGE, Aligned
from .joint_motion import RATE, bandpass
from .observation import Observation
from .transmission import Transmission

JUDGED_FROM = 0.5
"""Fraction of a recording from which a tracker judges; clock, base and tool are of that before."""
FLOOR_BAND = (22.0, 35.0)
"""[Hz] Band in which a tracker sees its own noise alone; taken as white."""


@dataclass(frozen=True, eq=False)
class Remaining:
    """Error at the tool in a band of frequency that the tracker sees, and what a model leaves."""

    rms: Array
    """(3,) [m], encoders alone, base axes."""
    ratio: Array
    """(3,), RMS with the model over RMS without."""
    pooled: float
    """The same over all axes."""
    floor: Array
    """(3,) [m], noise of the tracker in that band."""


def sensor_ratio(found: Transmission, one: Observation) -> float:
    """RMS of the sensor's weighted residual with the transmission error, over that without."""
    terms = zip(found.joints, found.orders, found.coefficients, strict=True)
    model = sum((one.columns(joint, order) @ x for joint, order, x in terms), np.zeros(()))
    left = np.abs(one.target - model) ** 2
    return float(np.sqrt(left.sum() / (np.abs(one.target) ** 2).sum()))


def judged_rows(aligned: Aligned) -> NDArray[np.bool_]:
    """(M,) bool, samples on which a tracker judges."""
    rows = aligned.tool_residual()[1].copy()
    rows[: int(JUDGED_FROM * len(rows))] = False
    rows[-int(EDGE * RATE) :] = False
    return rows


def remaining(
    residual: Array, estimate: Array, rows: NDArray[np.bool_], band: tuple[float, float]
) -> Remaining:
    """What an estimate (M, 3) [m] of the tool's error leaves of the one that a tracker saw."""
    seen, left = (bandpass(x, *band)[rows] for x in (residual, residual - estimate))
    width = (band[1] - band[0]) / (FLOOR_BAND[1] - FLOOR_BAND[0])
    noise = bandpass(residual, *FLOOR_BAND)[rows]
    return Remaining(
        rms=_rms(seen),
        ratio=_rms(left) / _rms(seen),
        pooled=float(np.sqrt((left**2).sum() / (seen**2).sum())),
        floor=np.sqrt(width) * _rms(noise),
    )


def _rms(x: Array) -> Array:
    return np.sqrt((x**2).mean(axis=0))
