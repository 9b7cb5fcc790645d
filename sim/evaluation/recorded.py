"""Measures of recorded data, of a stored run or of any other robot: one analysis for all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import ArrayLike

from armside.arrays import Array
from armside.ilc.measures import norms

from ..cut.tool_motion import ToolMotion
from ..instruments.laser_tracker import TrackerSamples
from ..part.motion import PartMotion
from ..records.signals import Signals
from .contour_error import contour_errors
from .tool_error import tool_error

KINDS = ("reference", "motor_angle")
TRACKER = ("tracker_x", "tracker_y", "tracker_z")


@dataclass(frozen=True, kw_only=True)
class CircleTurn:
    """One turn of a programmed circle, for data that do not state their path."""

    radius: float
    """Programmed [m]."""
    start: float = -np.inf
    end: float = np.inf
    """[s]."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Normal of the circle's plane, in the axes of the tracker."""

    def __post_init__(self) -> None:
        if not self.start < self.end:
            raise ValueError(f"start must be before end, got {self.start:g} and {self.end:g} s")


@dataclass(frozen=True, kw_only=True)
class RecordedMeasures:
    """Measures of one iteration; those of the arm are NaN without a tracker."""

    k: int
    motor_inf: Array
    motor_two: Array
    """(n,) [rad] of the motor shaft."""
    arm_rms: float
    arm_maxdev: float
    """[m], (9.6) and (9.7)."""


def measure_signals(signals: Signals) -> list[RecordedMeasures]:
    """Measures of each iteration of a stored run, along its stored path; no motion is planned.

    Raises ValueError for signals without programmed path or gear ratios.
    """
    path, gear = signals.path, signals.gear
    if path is None or gear is None:
        raise ValueError(
            f"the signals of `{signals.config.get('experiment')}`, armside {signals.version}, hold "
            f"no programmed path; a run of `laser` does: run it again if this is one"
        )
    rows = []
    for run in signals.runs:
        rms = maxdev = np.nan
        if run.tracker is not None:
            rms, maxdev = _tool(path, run.tracker)
        rows.append(_measures(run.k, run.recording.error * gear, rms, maxdev))
    return rows


def _tool(path: ToolMotion | PartMotion, seen: TrackerSamples) -> tuple[float, float]:
    """RMS and largest deviation [m] of a contour, or of all contours of a part by their length."""
    if isinstance(path, ToolMotion):
        tool = tool_error(path, seen.time, seen.position)
        return tool.rms, tool.maxdev
    each = contour_errors(path, seen.time, seen.position)
    length = [cut.turn.length for cut in path.cuts]
    rms = np.sqrt(np.average([tool.rms**2 for tool in each], weights=length))
    return float(rms), max(tool.maxdev for tool in each)


def measure_table(
    table: pa.Table, gear: ArrayLike, turn: CircleTurn | None
) -> list[RecordedMeasures]:
    """Measures of each iteration k in a table.

    Columns: `time` [s], `reference_1..n` and `motor_angle_1..n` [rad] on the arm side of the gear;
    optionally `k`, and `tracker_x`, `tracker_y`, `tracker_z` [m]. Rows may be of log, tracker, or
    both, with nothing where a column has no sample.

    Args:
        gear: (n,) ratios.
        turn: circle that the tracker saw; None measures the motors alone.

    Raises ValueError for columns that are missing, or not as many motors as gears.
    """
    gear = np.asarray(gear, dtype=np.float64)
    names = set(table.column_names)
    wanted = ["time"] + [f"{kind}_{i + 1}" for kind in KINDS for i in range(len(gear))]
    if absent := [name for name in wanted if name not in names]:
        raise ValueError(f"columns are missing: {', '.join(absent)}")
    if f"reference_{len(gear) + 1}" in names:
        raise ValueError(f"the data have more motors than the {len(gear)} gears given")
    ks = table["k"].unique().to_pylist() if "k" in names else [0]
    return [_one(table, k, gear, turn) for k in sorted(ks)]


def _one(table: pa.Table, k: int, gear: Array, turn: CircleTurn | None) -> RecordedMeasures:
    own = table.filter(pc.field("k") == k) if "k" in table.column_names else table
    reference, angle = (
        _block(own, [f"{kind}_{i + 1}" for i in range(len(gear))]) for kind in KINDS
    )
    logged = np.isfinite(reference).all(axis=1) & np.isfinite(angle).all(axis=1)
    rms = maxdev = np.nan
    if turn is not None and set(TRACKER) <= set(own.column_names):
        rms, maxdev = _circle(own, turn)
    return _measures(k, (reference - angle)[logged] * gear, rms, maxdev)


def _measures(k: int, motor_error: Array, rms: float, maxdev: float) -> RecordedMeasures:
    inf, two = norms.inf_norm(motor_error), norms.two_norm(motor_error)
    return RecordedMeasures(k=int(k), motor_inf=inf, motor_two=two, arm_rms=rms, arm_maxdev=maxdev)


def _circle(own: pa.Table, turn: CircleTurn) -> tuple[float, float]:
    time, point = _block(own, ["time"])[:, 0], _block(own, TRACKER)
    seen = np.isfinite(point).all(axis=1) & (time >= turn.start) & (time < turn.end)
    if seen.sum() < 3:
        return np.nan, np.nan
    radii = norms.fit_circle(point[seen], normal=turn.normal).radii
    return norms.circle_rms(radii, turn.radius), norms.circle_maxdev(radii, turn.radius)


def _block(table: pa.Table, names: Sequence[str]) -> Array:
    """(N, len(names)), NaN for missing values."""
    columns = [table[name].cast(pa.float64()).to_numpy(zero_copy_only=False) for name in names]
    return np.column_stack(columns)
