"""Measures and notes of recorded data, of a stored run or of any other robot: one analysis."""

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike

from armside.arrays import Array, check_numbers, check_recorded_time, check_rising, finite_array
from armside.ilc.measures import norms
from armside.kinematics import Limits

from ..instruments.laser_tracker import TrackerSamples, beam
from ..motion.contour import ClosedCurve
from ..motion.path import Plane
from ..motion.tool_motion import ToolMotion, motion_notes
from ..notes import Cause, Note, together
from ..part.motion import PartMotion
from ..recordings.recorded_motion import check_range
from ..records.signals import Signals
from ..records.tables import TRUTH_VALUE, float_columns, floats
from ..robot.recording import saturation
from .contour_error import contour_errors
from .tool_error import fit, tool_error

KINDS = ("reference", "motor_angle")
TRACKER = ("tracker_x", "tracker_y", "tracker_z")


@dataclass(frozen=True, kw_only=True)
class _Turn:
    """When the tracker saw one turn, and in which plane."""

    start: float = -np.inf
    end: float = np.inf
    """[s]."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Normal of the plane in the axes of the tracker, whose x axis, projected, is the contour's."""

    def __post_init__(self) -> None:
        check_numbers(self, "start", "end", nan=True)
        check_numbers(self, *(["radius"] if hasattr(self, "radius") else []))
        if not self.start < self.end:
            raise ValueError(f"start must be before end, got {self.start:g} and {self.end:g} s")


@dataclass(frozen=True, kw_only=True)
class CircleTurn(_Turn):
    """One turn of a programmed circle, for data that do not state their path."""

    radius: float
    """Programmed [m]."""


@dataclass(frozen=True, kw_only=True)
class ContourTurn(_Turn):
    """One turn of a programmed contour, for data that do not state their path.

    Its place is found by a best fit, as for any contour; its plane and, to some 20 degrees, its
    rotation there are given.
    """

    contour: ClosedCurve
    turned: float = 0.0
    """Rotation of the contour in that plane [rad]."""


@dataclass(frozen=True, kw_only=True)
class IterationMeasures:
    """Measures of one iteration; NaN for the arm without a tracker and for a motor without samples,
    empty without motors."""

    k: int
    motor_inf: Array
    motor_two: Array
    """(n,) [rad] of the motor shaft."""
    arm_rms: float
    arm_maxdev: float
    """[m], (9.6) and (9.7)."""


def measure_signals(signals: Signals, limits: Limits | None = None) -> list[IterationMeasures]:
    """Measures of each iteration of a stored run, along its stored path; no motion is planned.

    limits: of the robot, as of `measure_table`.

    Raises ValueError for signals without programmed path or gear ratios, or angles out of range.
    """
    path, gear = signals.path, signals.gear
    if path is None or gear is None:
        raise ValueError(
            f"the signals of `{signals.config.get('experiment')}`, armside {signals.version}, hold "
            f"no programmed path; a run of `laser` does: run it again if this is one"
        )
    rows = []
    for run in signals.runs:
        for name in KINDS:
            check_range(f"k = {run.k}", name, getattr(run.recording, name), limits)
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
    table: pa.Table,
    gear: ArrayLike,
    turn: CircleTurn | ContourTurn | None,
    limits: Limits | None = None,
) -> list[IterationMeasures]:
    """Measures of each iteration k in a table.

    Columns: `time` [s], `reference_1..n` and `motor_angle_1..n` [rad] on the arm side of the gear;
    optionally `k`, and `tracker_x`, `tracker_y`, `tracker_z` [m]. Rows may be of log, tracker, or
    both, with nothing where a column has no sample.

    Args:
        gear: (n,) ratios; none for data of the tracker alone.
        turn: circle or contour that the tracker saw; None measures the motors alone.
        limits: of the robot, by which angles in degrees are noticed; else some turns of each axis
            with a gear.

    Raises ValueError for columns that are missing, or not as many motors as gears; without gears
    for data in which there is no turn to measure; with column, row and value for times that do not
    increase, at no rate of an instrument, or with a gap, and for angles out of range.
    """
    gear = finite_array("gear", gear)
    if gear.ndim != 1:
        raise ValueError(f"gear must have shape (n,), got {gear.shape}")
    names = set(table.column_names)
    wanted = ["time"] + [f"{kind}_{i + 1}" for kind in KINDS for i in range(len(gear))]
    if absent := [name for name in wanted if name not in names]:
        raise ValueError(f"columns are missing: {', '.join(absent)}")
    if f"reference_{len(gear) + 1}" in names:
        raise ValueError(f"the data have more motors than the {len(gear)} gears given")
    if not len(gear) and (turn is None or not set(TRACKER) <= names):
        raise ValueError(
            "without motors, columns of a tracker and the circle or contour are needed"
        )
    ks = table["k"].unique().to_pylist() if "k" in names else [0]
    rows = [_one(table, k, gear, turn, limits) for k in sorted(ks)]
    if not any(np.isfinite([*row.motor_inf, row.arm_rms]).any() for row in rows):
        raise ValueError("the data hold no samples of motors or tool")
    return rows


def _one(
    table: pa.Table,
    k: int,
    gear: Array,
    turn: CircleTurn | ContourTurn | None,
    limits: Limits | None,
) -> IterationMeasures:
    whole = np.full(table.num_rows, True)
    rows = np.flatnonzero(floats(table, "k") == k if "k" in table.column_names else whole)
    own = table.take(rows)
    time = floats(own, "time")
    signals = [float_columns(own, [f"{kind}_{i + 1}" for i in range(len(gear))]) for kind in KINDS]
    for name, values in zip(KINDS, signals, strict=True):
        # Without a gear they are angles of the motor shaft, which turn without bound.
        arm_side = values if limits is not None else np.where(np.abs(gear) == 1.0, 0.0, values)
        check_range(f"k = {k}", name, arm_side, limits, rows)
    reference, angle = signals
    error = (reference - angle) * gear
    log = np.isfinite(error).any(axis=1)
    check_recorded_time(f"k = {k}: log", time[log], rows[log])
    rms = maxdev = np.nan
    if turn is not None and set(TRACKER) <= set(own.column_names):
        point = float_columns(own, TRACKER)
        there = np.isfinite(point).all(axis=1)
        check_rising(f"k = {k}: tracker", time[there], rows[there])
        seen = there & (time >= turn.start) & (time < turn.end)
        check_recorded_time(f"k = {k}: tracker", time[seen], rows[seen])
        rms, maxdev = _deviation(point[seen], turn)
    return _measures(k, error, rms, maxdev)


def _measures(k: int, motor_error: Array, rms: float, maxdev: float) -> IterationMeasures:
    there = np.isfinite(motor_error)
    some = there.any(axis=0)
    inf, two = np.full((2, motor_error.shape[1]), np.nan)
    whole = motor_error if some.all() else motor_error[:, some]
    whole = whole if there.all() else whole[there[:, some].all(axis=1)]
    if whole.size:
        inf[some], two[some] = norms.inf_norm(whole), norms.two_norm(whole)
    return IterationMeasures(k=int(k), motor_inf=inf, motor_two=two, arm_rms=rms, arm_maxdev=maxdev)


def _deviation(point: Array, turn: CircleTurn | ContourTurn) -> tuple[float, float]:
    """RMS and largest distance [m] of points (M, 3) from the contour, after a best fit to it."""
    if len(point) < 3:
        return np.nan, np.nan
    if isinstance(turn, CircleTurn):
        radii = norms.fit_circle(point, normal=turn.normal).radii
        return norms.circle_rms(radii, turn.radius), norms.circle_maxdev(radii, turn.radius)
    plane = Plane.perpendicular_to(turn.normal, point.mean(axis=0))
    c, s = np.cos(turn.turned), np.sin(turn.turned)
    flat = plane.from_base(point)[:, :2] @ np.array([[c, -s], [s, c]])
    outline = turn.contour.point(np.linspace(0.0, turn.contour.length, 400, endpoint=False))
    middle = [0.5 * (p.min(axis=0) + p.max(axis=0)) for p in (outline, flat)]
    deviation = fit(turn.contour, flat + (middle[0] - middle[1])).deviation
    return float(np.sqrt(np.mean(deviation**2))), float(np.abs(deviation).max())


def notes_of_signals(signals: Signals) -> list[Note]:
    """Notes of a stored run: of its programmed path, and of each iteration."""
    found = [*motion_notes(signals.path)] if isinstance(signals.path, ToolMotion) else []
    for run in signals.runs:
        of_tracker = () if run.tracker is None else beam(run.tracker)
        found += [note.at(run.k) for note in (*saturation(run.recording), *of_tracker)]
    return together(found)


def notes_of_table(table: pa.Table) -> list[Note]:
    """Notes of any other table: samples that its column `tracker_valid` calls lost."""
    known = TRUTH_VALUE in table.column_names
    seen = table[TRUTH_VALUE].cast(pa.bool_()).to_pylist() if known else []
    text = f"the laser tracker lost its beam in {seen.count(False)} samples, which are left out"
    return [Note(cause=Cause.BEAM, text=text)] if False in seen else []
