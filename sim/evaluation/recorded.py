"""Measures of recorded data, whoever recorded it: the same analysis as for a run of our own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.measures import norms as measures


@dataclass(frozen=True, kw_only=True)
class Cut:
    """What the tool was to cut, where the data do not say it: one turn of a circle."""

    radius: float
    """Programmed [m]."""
    start: float = -np.inf
    """[s], of the turn."""
    end: float = np.inf
    """[s]."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Of the circle's plane, in the axes of the tracker."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Measures of one iteration; those of the arm are NaN without a tracker."""

    k: int
    motor_inf: Array
    """(n,) [rad] of the motor shaft."""
    motor_two: Array
    """(n,) [rad] of the motor shaft."""
    arm_rms: float
    """[m], (9.6)."""
    arm_maxdev: float
    """[m], (9.7)."""


def measure_table(table: pa.Table, gear: ArrayLike, cut: Cut | None) -> list[Measured]:
    """Measures of each iteration k in a table.

    Columns: `time` [s], `reference_1..n` and `motor_angle_1..n` [rad] on the arm side of the gear;
    optionally `k`, and `tracker_x`, `tracker_y`, `tracker_z` [m]. Rows may be of log, tracker, or
    both, with nothing where a column has no sample.

    Args:
        gear: (n,) ratios.

    Raises:
        ValueError: columns that are missing, or not as many motors as gears.
    """
    gear = np.asarray(gear, dtype=np.float64)
    names = set(table.column_names)
    wanted = ["time"] + [f"{kind}_{i + 1}" for kind in KINDS for i in range(len(gear))]
    if absent := [name for name in wanted if name not in names]:
        raise ValueError(f"columns are missing: {', '.join(absent)}")
    if f"reference_{len(gear) + 1}" in names:
        raise ValueError(f"the data have more motors than the {len(gear)} gears given")
    ks = table["k"].unique().to_pylist() if "k" in names else [0]
    return [_one(table, k, gear, cut) for k in sorted(ks)]


KINDS = ("reference", "motor_angle")
TRACKER = ("tracker_x", "tracker_y", "tracker_z")


def _one(table: pa.Table, k: int, gear: Array, cut: Cut | None) -> Measured:
    own = table.filter(pc.field("k") == k) if "k" in table.column_names else table
    reference, angle = (
        _block(own, [f"{kind}_{i + 1}" for i in range(len(gear))]) for kind in KINDS
    )
    logged = np.isfinite(reference).all(axis=1) & np.isfinite(angle).all(axis=1)
    error = (reference - angle)[logged] * gear
    rms = maxdev = np.nan
    if cut is not None and set(TRACKER) <= set(own.column_names):
        rms, maxdev = _circle(own, cut)
    return Measured(
        k=int(k),
        motor_inf=measures.inf_norm(error),
        motor_two=measures.two_norm(error),
        arm_rms=rms,
        arm_maxdev=maxdev,
    )


def _circle(own: pa.Table, cut: Cut) -> tuple[float, float]:
    time = _block(own, ["time"])[:, 0]
    point = _block(own, TRACKER)
    seen = np.isfinite(point).all(axis=1) & (time >= cut.start) & (time < cut.end)
    if seen.sum() < 3:
        return np.nan, np.nan
    radii = measures.fit_circle(point[seen], normal=cut.normal).radii
    return measures.circle_rms(radii, cut.radius), measures.circle_maxdev(radii, cut.radius)


def _block(table: pa.Table, names: Sequence[str]) -> Array:
    """(N, len(names)), NaN for what is missing."""
    columns = [table[name].cast(pa.float64()).to_numpy(zero_copy_only=False) for name in names]
    return np.column_stack(columns)
