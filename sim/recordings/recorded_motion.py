"""Recordings of real arms, in motion or of poses: their plausibility, and repair of their samples.

What is wrong is dropped and counted, never guessed: later steps interpolate over time stamps.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from armside.arrays import Array, check_recorded_time
from armside.kinematics import Limits
from armside.kinematics.calibration import Measurements


@dataclass(frozen=True, eq=False)
class Stream:
    """Samples of one instrument by its own clock."""

    time: Array
    """(N,) [s], increasing; not evenly spaced."""
    values: Array
    """(N, m)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecording:
    """One recording of an arm of n motors in motion. The clocks need not agree."""

    name: str
    encoders: Stream
    """(N, n) [rad], motor angles on the arm side of the gear."""
    imu: Stream | None = None
    """(K, 6), specific force [m/s^2] and angular rate [rad/s] in the axes of the housing."""
    tracker: Stream | None = None
    """(L, 3) [m], a point fixed to the tool, in the frame of the instrument."""
    form: str
    notes: tuple[str, ...] = ()
    """What was repaired or converted, a line each."""


@dataclass(frozen=True, eq=False)
class PoseRecording:
    """Measured poses, and what was left out of them and why."""

    measurements: Measurements
    form: str
    """Name of the form that was recognised."""
    notes: tuple[str, ...] = ()
    """One line for each kind of row that was left out."""


OUT_OF_RANGE = 1.1
"""Motor angle relative to its limit from which the unit is doubted."""

SHORTEST = 10.0
"""[s] Of a recording from which clocks and mountings can be found. ESTIMATE."""


def check_times(recording: MotionRecording) -> None:
    """Raise ValueError for recordings that are too short, or that lack a stretch."""
    for name in ("encoders", "imu"):
        stream = getattr(recording, name)
        if stream is None:
            continue
        if (length := stream.time[-1] - stream.time[0]) < SHORTEST:
            text = f"{length:.3g} s of samples; at least {SHORTEST:g} s are needed"
            raise ValueError(f"{recording.name}: {name}: {text}")
        check_recorded_time(f"{recording.name}: {name}", stream.time)


def check_angles(limits: Limits, recording: MotionRecording) -> None:
    """Raise ValueError for motor angles that are far out of range: degrees, or another robot."""
    check_range(recording.name, "motor_angle", recording.encoders.values, limits)


TURNS = 4.0 * np.pi
"""[rad] On the arm side, that no axis of an unknown robot is at. ESTIMATE: axes of six-axis robots
turn at most 400 degrees to either side."""


def check_range(
    source: str, signal: str, angles: Array, limits: Limits | None, rows: Any = None
) -> None:
    """Refuse motor angles (N, n) [rad, arm side] far beyond their limits, or `TURNS` without any.

    Raises ValueError with column (`signal` and its number), row (of `rows` from 0) and value.
    """
    bound = np.full(angles.shape[1], TURNS)
    if limits is not None:
        bound = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
    if angles.shape[1:] != bound.shape:
        text = f"the robot has {len(bound)} motors, the recording has {angles.shape[1]}"
        raise ValueError(f"{source}: {text}")
    ratio = np.nan_to_num(np.abs(angles) / bound)
    row, worst = np.unravel_index(int(ratio.argmax()), ratio.shape) if ratio.size else (0, 0)
    if ratio.size and ratio[row, worst] > OUT_OF_RANGE:
        unit = "is it this robot?" if ratio[row, worst] < 2.0 else "are the angles in degrees?"
        at = 1 + int(row if rows is None else rows[row])
        text = f"reaches {abs(angles[row, worst]):.3g}, its limit is {bound[worst]:.3g} rad; {unit}"
        raise ValueError(f"{source}: {signal}_{worst + 1} {text} (row {at})")


SPIKE = 8.0
"""Deviation from the neighbours, in robust standard deviations, from which a sample is wrong.
Real encoders hold a value for one more cycle of the controller now and then."""
AROUND = 21
"""Samples about one that say what is usual: a spike spoils the deviation of five, a corner of the
path that of all. ESTIMATE"""
ROUNDING = 1e-12
"""Deviation from the neighbours, in standard deviations of the record, of readings that are one."""
MOVES = 20
"""Samples that do not repeat their neighbours, below which a record is at rest. ESTIMATE"""
ROUNDS = 6
"""Repetitions of the search: a spike hides its neighbours."""
GAP = 5.0
"""Step in time, relative to the median step, that is reported as a gap."""
LOST = 0.2
"""Fraction of samples that may be missing or wrong."""
BACKWARDS = 0.01
"""Fraction of steps in time that may go backwards."""
FEWEST = 100
"""Samples of a stream that can be analysed."""
LONGEST = 1800.0
"""[s] Of a stream that can be analysed."""
LARGEST = 1e6
"""[SI] Value that no instrument gives."""


def repaired(name: str, time: Array, values: Array) -> tuple[Stream, tuple[str, ...]]:
    """Stream (N,) [s], (N, m) without repeated stamps, missing values (NaN) and spikes, and notes.

    Raises ValueError where it is too short or long, lacks too much, or its clock runs backwards.
    """
    if len(time) < FEWEST:
        raise ValueError(f"{name}: {len(time)} samples; at least {FEWEST} are needed")
    whole = np.isfinite(time) & np.isfinite(values).all(axis=1)
    _refuse_most(name, "are not finite", ~whole)
    time, values = time[whole], values[whole]
    if (largest := float(np.abs(values).max())) > LARGEST:
        raise ValueError(f"{name}: values reach {largest:.3g}; at most {LARGEST:g} can be right")
    steps = np.diff(time)
    if (back := steps < 0.0).mean() > BACKWARDS:
        row = int(np.flatnonzero(back)[0]) + 2
        raise ValueError(f"{name}: the clock runs backwards, first in sample {row}")
    reached = np.maximum.accumulate(time)
    _refuse_most(name, "are older than those before them: the clock is set back", time < reached)
    forward = np.r_[True, time[1:] > reached[:-1]]
    time, values = time[forward], values[forward]
    check_recorded_time(name, time, np.flatnonzero(whole)[forward], gap=np.inf)
    if not 0.0 < (length := time[-1] - time[0]) <= LONGEST:
        raise ValueError(f"{name}: {length:.3g} s of samples; at most {LONGEST:g} s can be used")
    kept = _without_spikes(time, values)
    _refuse_most(name, "lie off their neighbours", ~kept)
    stream = Stream(time[kept], values[kept])
    faults = ("not finite", "with a repeated or older stamp", "off their neighbours")
    lost = [(int((~own).sum()), f) for own, f in zip((whole, forward, kept), faults, strict=True)]
    said = ", ".join(f"{number} {fault}" for number, fault in lost if number)
    notes = [f"{name}: samples dropped: {said}"] if said else []
    steps = np.diff(stream.time)
    if len(gaps := steps[steps > GAP * np.median(steps)]):
        longest = f"the longest {1e3 * gaps.max():.0f} ms"
        notes.append(f"{name}: {len(gaps)} gaps are bridged, {longest}")
    return stream, tuple(notes)


def _refuse_most(name: str, fault: str, bad: NDArray[np.bool_]) -> None:
    if bad.mean() > LOST:
        raise ValueError(f"{name}: {100 * bad.mean():.0f} % of the samples {fault}")


def _without_spikes(time: Array, values: Array) -> NDArray[np.bool_]:
    """Mask of the samples that agree with a cubic through two neighbours on either side."""
    rows = np.arange(len(time))
    scale = np.maximum(values.std(axis=0), np.finfo(float).tiny)
    for _ in range(ROUNDS):
        off = _deviation(time[rows], values[rows] / scale)
        largest = np.max([np.roll(off, k) for k in range(-2, 3)], axis=0)
        moves, alone = _beside_rest(values[rows])
        moves &= ~np.any([np.roll(alone, k) for k in range(-2, 3)], axis=0)
        usual = float(np.median(off[moves])) if moves.sum() >= MOVES else 0.0
        around = np.maximum(median_filter(off, AROUND), usual)
        limit = np.maximum(SPIKE * 1.4826 * around, ROUNDING)
        bad = (off > limit) & (off == largest)
        if not bad.any():
            break
        rows = rows[~bad]
    kept = np.zeros(len(time), dtype=bool)
    kept[rows] = True
    return kept


def _beside_rest(values: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the samples that do not repeat two neighbours on either side, and of those whose
    neighbours repeat one another: at rest readings are equal, and say nothing of those in motion.
    """
    same = (np.diff(values, axis=0) == 0.0).all(axis=1)
    across = (values[1:-3] == values[3:-1]).all(axis=1)
    moves, alone = np.ones((2, len(values)), dtype=bool)
    moves[2:-2] = ~(same[:-3] & same[1:-2] & same[2:-1] & same[3:])
    alone[:2], alone[-2:] = False, False
    alone[2:-2] = moves[2:-2] & same[:-3] & across & same[3:]
    return moves, alone


def _deviation(time: Array, values: Array) -> Array:
    """Distance (N,) of each sample from the cubic through its neighbours; zero at ends and beside
    gaps."""
    inner, others = np.arange(2, len(time) - 2), {-2, -1, 1, 2}
    expected = np.zeros((len(inner), values.shape[1]))
    for a in sorted(others):
        weight = np.ones(len(inner))
        for b in sorted(others - {a}):
            weight *= (time[inner] - time[inner + b]) / (time[inner + a] - time[inner + b])
        expected += weight[:, None] * values[inner + a]
    off = np.zeros(len(time))
    span = time[inner + 2] - time[inner - 2]
    near = span <= GAP * np.median(span)
    off[inner] = near * np.linalg.norm(values[inner] - expected, axis=1)
    return off
