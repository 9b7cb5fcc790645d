"""A stored correction for a controller or another program: as columns, or as messages.

The correction, the commanded joint path or the commanded tool path, at any sample rate; or the
messages of a protocol, one for each of its cycles. Angles are of the motors, on the arm side of the
gear [rad]; positions of the tool in base axes [m].
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from armside import kinematics
from armside.arrays import Array
from armside.ilc.filters import Edge, ZeroPhaseButterworth
from armside.kinematics import Joint
from armside.kinematics.rotation import to_quaternion

from ..cell import Cell
from ..records.tables import table_of
from .messages import Answer, Wire
from .plant import PERIOD
from .rsi import RsiWire
from .stored_correction import StoredCorrection

BAND = 0.4
"""Cutoff of the low-pass over the new rate."""
RATES = (1.0, 20_000.0)
"""[Hz], lowest and highest."""
MOST_SAMPLES = 5_000_000
Columns = dict[str, tuple[str, Array]]
"""Unit and values by name."""
Form = Literal["joint-correction", "joint-path", "tool-path"]
TOOL = {"x": "m", "y": "m", "z": "m"} | dict.fromkeys(("qw", "qx", "qy", "qz"), "1")


def resampled(values: Array, sample_time: float, rate: float) -> Array:
    """Values (N, n) of a sample time [s] at a rate [Hz], with their band limited: shape (M, n).

    At the same rate samples are taken as they are. At a higher one a cubic spline goes through
    every sample. At a lower one the signal first passes a zero-phase Butterworth low-pass (order 2,
    forwards and backwards, gain 1/2 at 0.4 of the new rate), so that nothing above half the new
    rate folds back. The last value is held to the first new sample at or beyond the old end.

    Raises ValueError for a rate out of range, or one that is too low for so short a record.
    """
    from scipy.interpolate import CubicSpline

    low, high = RATES
    if not low <= rate <= high:
        raise ValueError(f"rate must be {low:g} to {high:g} Hz, got {rate:g}")
    if np.isclose(rate * sample_time, 1.0, rtol=1e-9, atol=0.0):
        return values
    end = (len(values) - 1) * sample_time
    count = int(np.ceil(end * rate - 1e-6)) + 1
    if count > MOST_SAMPLES:
        raise ValueError(f"at most {MOST_SAMPLES} samples are written, {rate:g} Hz make {count}")
    if rate * sample_time < 1.0:
        values = ZeroPhaseButterworth(BAND * rate, sample_time, edge=Edge.ODD)(values)
    time = np.arange(len(values)) * sample_time
    return CubicSpline(time, values)(np.minimum(np.arange(count) / rate, end))


def joint_values(stored: StoredCorrection, form: Form, rate: float) -> Array:
    """(M, n) at a rate [Hz]: u, or r + u from which the other two forms are made."""
    u = stored.correction
    values = u if form == "joint-correction" else stored.reference + u
    return resampled(values, stored.sample_time, rate)


def joint_columns(joints: Array, form: Form, units: Sequence[str]) -> Columns:
    """A column for each axis."""
    name = "correction" if form == "joint-correction" else "joint"
    each = zip(units, joints.T, strict=True)
    return {f"{name}_{i}": found for i, found in enumerate(each, start=1)}


def tool_columns(joints: Array, cell: Cell) -> Columns:
    """Position and unit quaternion of TCP0 in base axes, by the nominal kinematics at the
    angles."""
    if (n := len(cell.limits.lower)) != joints.shape[1]:
        raise ValueError(f"the robot has {n} axes and the correction {joints.shape[1]}")
    T_base_tool = kinematics.compile(cell.robot).pose(np.ascontiguousarray(joints))
    quaternion = _continuous(to_quaternion(T_base_tool[:, :3, :3]))
    values = np.column_stack((T_base_tool[:, :3, 3], quaternion))
    names = zip(TOOL.items(), values.T, strict=True)
    return {f"tool_{name}": (unit, column) for (name, unit), column in names}


def units_of(cell: Cell | None, n_axes: int, angle: str) -> list[str]:
    """Unit of each axis: that of angles, or m of a sliding one."""
    joints = [] if cell is None else [link.joint for link in cell.robot.links]
    moving = [joint for joint in joints if joint is not Joint.FIXED]
    return ["m" if joint is Joint.PRISMATIC else angle for joint in moving] or [angle] * n_axes


def table(found: Columns, rate: float, about: Mapping[str, Any]) -> pa.Table:
    """Columns with `time` [s] before them, and JSON texts of what they are as metadata."""
    count = len(next(iter(found.values()))[1])
    timed = {"time": ("s", np.arange(count) / rate), **found}
    return table_of(timed, {f"armside.{key}": text for key, text in about.items()})


def _continuous(quaternion: Array) -> Array:
    """The same rotations (M, 4) without jumps of sign."""
    sign = np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return quaternion * np.concatenate(([1.0], np.cumprod(sign)))[:, np.newaxis]


def rsi_lines(correction: Array, beyond: Sequence[str] = ()) -> bytes:
    """Corrections (M, n) [rad] for RSI, a sample each cycle: one `Sen` element a line, AKorr in
    [deg]. IPOC counts from zero: a sender replaces it. beyond: what the gate let through, a comment
    each."""
    comments = "".join(f"<!-- {line} -->\n" for line in beyond)
    return comments.encode() + b"".join(line + b"\n" for line in _answers(RsiWire(), correction))


def egm_messages(joints: Array) -> bytes:
    """Absolute angles (M, n) [rad] for EGM, a sample each cycle: EgmSensor messages with joints
    [deg], each after its length as a protobuf varint. Time stamps count from zero."""
    from .egm import EgmWire

    return b"".join(varint(len(each)) + each for each in _answers(EgmWire(), joints))


def _answers(wire: Wire, values: Array) -> Iterator[bytes]:
    for i, row in enumerate(np.rad2deg(values)):
        answer = Answer(values=row, additive=wire.additive)
        yield wire.encode_answer(answer, round(1e3 * i * PERIOD))


def varint(value: int) -> bytes:
    """A whole number >= 0, seven bits a byte, the lowest first."""
    low, rest = value & 0x7F, value >> 7
    return bytes([low | 0x80]) + varint(rest) if rest else bytes([low])
