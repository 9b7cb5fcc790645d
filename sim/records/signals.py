"""`signals.parquet`: every signal of an experiment in one table, and back into the same arrays.

One row per iteration k and instant. Columns of the log are filled at the log rate, those of the
tracker and of the truth at theirs, null elsewhere; a lost beam is NaN with `tracker_valid` false.
Units stand in the metadata of each column; configuration, programmed path and gear ratios in that
of the table.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, check_recorded_time

from ..instruments.laser_tracker import TrackerSamples
from ..instruments.noise import rate_of, stride
from ..motion.tool_motion import ToolMotion
from ..part.motion import PartMotion
from ..robot.drives import EXACT
from ..robot.recording import Recording, Truth
from .atomic import atomic
from .programmed_path import from_json, to_json
from .tables import floats, table_of

XYZ = tuple("xyz")
LOG = dict.fromkeys(("reference", "correction", "motor_angle"), "rad") | {"motor_torque": "N m"}
"""Units of the log's signals, each with a column for each axis."""
TRUE_AXES = {"motor_angle": "rad", "flex_angle": "rad", "motor_torque": "N m"}
TRUE_TOOL = {
    "tool_position": ("m", XYZ),
    "tool_quaternion": ("1", tuple("wxyz")),
    "imu_acceleration": ("m/s^2", XYZ),
    "imu_angular_velocity": ("rad/s", XYZ),
}
FORMAT = 1
"""Format of the file; raised when an older one can no longer be read."""
SHORTEST_INTERVAL = 1e-9
"""Smallest distance of two samples [s]; below it their clocks were computed differently."""
NO_TRACKER = TrackerSamples(
    time=np.empty(0), position=np.empty((0, 3)), valid=np.empty(0, dtype=bool)
)


@dataclass(frozen=True, kw_only=True)
class RecordedRun:
    """Recorded signals of iteration k of an experiment."""

    k: int
    recording: Recording
    tracker: TrackerSamples | None = None


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Content of a file of signals."""

    runs: tuple[RecordedRun, ...]
    """The truth is at the rate it was written with, by default 1000 Hz."""
    config: dict[str, Any]
    seed: int | None
    version: str
    path: ToolMotion | PartMotion | None = None
    """Programmed path; None where none was cut, or in a file of armside before this was stored."""
    gear: Array | None = None
    """(n,) gear ratios; None where the file has none."""


def write_signals(
    path: Path,
    runs: Sequence[RecordedRun],
    *,
    config: Mapping[str, Any],
    seed: int | None,
    truth_rate: float = 1000.0,
    motion: ToolMotion | PartMotion | None = None,
    gear: ArrayLike | None = None,
) -> None:
    """Write the runs to one file, whole or not at all. The same data gives the same bytes.

    truth_rate: [Hz]. motion: programmed path, the same for all runs. gear: (n,) gear ratios.

    Raises ValueError for no runs, an iteration twice, a truth rate that does not divide the
    record's, two clocks that nearly agree, or a contour that cannot be stored.
    """
    ks = [run.k for run in runs]
    if not ks or len(set(ks)) != len(ks):
        raise ValueError(f"signals need one or more runs with different k, got k = {ks}")
    metadata = {
        "config": json.dumps(dict(config), sort_keys=True),
        "format": json.dumps(FORMAT),
        "limits_hit": json.dumps({str(run.k): run.recording.limits_hit for run in runs}),
        "rates": json.dumps(_rates(runs[0], truth_rate)),
        "seed": json.dumps(seed),
        "version": version("armside"),
    }
    if motion is not None:
        metadata["path"] = json.dumps(to_json(motion))
    if gear is not None:
        metadata["gear"] = json.dumps(np.asarray(gear, dtype=np.float64).tolist())
    table = pa.concat_tables(_table(run, truth_rate) for run in runs)
    table = table.replace_schema_metadata({f"armside.{k}": text for k, text in metadata.items()})
    numbers = [field.name for field in table.schema if field.type == pa.float64()]
    with atomic(path) as partial:
        pq.write_table(
            table,
            partial,
            compression="zstd",
            use_dictionary=False,  # measured floats hardly repeat
            use_byte_stream_split=numbers,  # pyright: ignore[reportArgumentType]
        )


def read_signals(path: Path) -> Signals:
    """Runs of a file, bit for bit as written. Raises ValueError as `signals_of`."""
    return signals_of(pq.read_table(path), source=str(path))


def signals_of(table: pa.Table, *, source: str = "the table") -> Signals:
    """Runs of a table with the columns and the metadata of `write_signals`, or ValueError."""
    metadata = {key.decode(): text.decode() for key, text in (table.schema.metadata or {}).items()}
    if "armside.config" not in metadata:
        raise ValueError(f"{source} holds no signals of armside: no armside.config in its metadata")
    if (found := json.loads(metadata.get("armside.format", "0"))) != FORMAT:
        raise ValueError(f"{source} holds signals of format {found}; this armside reads {FORMAT}")
    if missing := missing_columns(table):
        raise ValueError(f"{source} lacks the column {missing[0]}")
    if not table.num_rows:
        raise ValueError(f"{source} has no rows")
    limits_hit = json.loads(metadata["armside.limits_hit"])
    path, gear = (json.loads(metadata.get(f"armside.{key}", "null")) for key in ("path", "gear"))
    ks = table["k"].unique().to_pylist()
    return Signals(
        runs=tuple(_run(k, table.filter(pc.field("k") == k), limits_hit[str(k)]) for k in ks),
        config=json.loads(metadata["armside.config"]),
        seed=json.loads(metadata["armside.seed"]),
        version=metadata["armside.version"],
        path=None if path is None else from_json(path),
        gear=None if gear is None else np.array(gear),
    )


def missing_columns(table: pa.Table) -> list[str]:
    """Columns of `write_signals` that the table lacks."""
    log, true = _blocks(_axes_in(table), 1)
    blocks = [*log.items(), ("tracker", ("m", (*XYZ, "valid")))]
    blocks += [(f"true_{name}", block) for name, block in true.items()]
    needed = ["k", "time", *(f"{name}_{s}" for name, (_, suffixes) in blocks for s in suffixes)]
    return [name for name in needed if name not in table.column_names]


_Blocks = dict[str, tuple[str, tuple[str, ...]]]
"""Unit and suffixes of the columns of each signal."""


def _axes_in(table: pa.Table) -> int:
    """Number of axes of the columns of a table: the last axis that any signal of the log has."""
    names = (name.rpartition("_") for name in table.column_names)
    found = (int(i) for signal, _, i in names if signal in LOG and i.isdecimal())
    return max(found, default=1)


def _blocks(n_axes: int, n_qpos: int) -> tuple[_Blocks, _Blocks]:
    """Signals of the log, and of the truth."""
    axes = tuple(str(i + 1) for i in range(n_axes))
    log, true = ({name: (u, axes) for name, u in of.items()} for of in (LOG, TRUE_AXES))
    return log, true | TRUE_TOOL | {"qpos": ("rad or m", tuple(map(str, range(n_qpos))))}


def _table(run: RecordedRun, truth_rate: float) -> pa.Table:
    """Table of one run: the union of the instants of its streams."""
    recording, tracker = run.recording, run.tracker or NO_TRACKER
    truth = recording.truth.every(stride(rate_of(recording.truth.time), truth_rate))
    log, true = _blocks(recording.n_axes, truth.qpos.shape[1])
    blocks = [(n, *of, recording.time, getattr(recording, n)) for n, of in log.items()]
    blocks.append(("tracker", "m", XYZ, tracker.time, tracker.position))
    blocks.append(("tracker", "1", ("valid",), tracker.time, tracker.valid[:, np.newaxis]))
    blocks += [(f"true_{n}", *of, truth.time, getattr(truth, n)) for n, of in true.items()]
    time = np.unique(np.concatenate([recording.time, truth.time, tracker.time]))
    if len(time) > 1 and np.diff(time).min() < SHORTEST_INTERVAL:
        raise ValueError("sample times of log, truth and tracker must come from one grid of time")
    columns = {"k": ("1", np.full(len(time), run.k, dtype=np.int32)), "time": ("s", time)}
    for prefix, unit, suffixes, own_time, values in blocks:
        for suffix, column in zip(suffixes, _spread(time, own_time, values), strict=True):
            columns[f"{prefix}_{suffix}"] = (unit, column)
    return table_of(columns)


def _spread(time: Array, own_time: Array, values: NDArray[Any]) -> list[pa.Array]:
    """Columns of `values` at their rows of the common time, null in between."""
    row = np.searchsorted(time, own_time)
    null = np.ones(len(time), dtype=bool)
    null[row] = False
    columns = np.zeros((values.shape[1], len(time)), dtype=values.dtype)
    columns[:, row] = values.T
    return [pa.array(column, mask=null) for column in columns]


def _rates(run: RecordedRun, truth_rate: float) -> dict[str, float]:
    rates = {"log": rate_of(run.recording.time), "truth": truth_rate}
    if run.tracker:
        rates["tracker"] = rate_of(run.tracker.time)
    return {name: round(rate, 6) for name, rate in rates.items()}


def _run(k: int, table: pa.Table, limits_hit: Sequence[tuple[Any, Any, Any]]) -> RecordedRun:
    log = table.filter(pc.field("reference_1").is_valid())
    true = table.filter(pc.field("true_tool_position_x").is_valid())
    n_qpos = sum(name.startswith("true_qpos_") for name in table.column_names)
    of_log, of_truth = _blocks(_axes_in(table), n_qpos)
    stored = {name: _stack(true, f"true_{name}", s) for name, (_, s) in of_truth.items()}
    signals = {name: _stack(log, name, s) for name, (_, s) in of_log.items()}
    # The gear error is part of the stored angles already.
    angles = {"gear_angle": stored.pop("motor_angle"), "spring_angle": stored.pop("flex_angle")}
    truth = Truth(time=_time(true, k, "truth"), gear_error=EXACT, **angles, **stored)
    time = _time(log, k, "log")
    hits = tuple((str(a), int(b), float(c)) for a, b, c in limits_hit)
    recording = Recording(time=time, truth=truth, limits_hit=hits, **signals)
    return RecordedRun(k=k, recording=recording, tracker=_tracker(table, k))


def _tracker(table: pa.Table, k: int) -> TrackerSamples | None:
    seen = table.filter(pc.field("tracker_valid").is_valid())
    if seen.num_rows == 0:
        return None
    position, valid = _stack(seen, "tracker", XYZ), seen["tracker_valid"].to_numpy()
    return TrackerSamples(time=_time(seen, k, "tracker"), position=position, valid=valid)


def _time(table: pa.Table, k: int, stream: str) -> Array:
    time = floats(table, "time")
    check_recorded_time(f"k = {k}: {stream}", time)
    return time


def _stack(table: pa.Table, prefix: str, suffixes: Sequence[str]) -> Array:
    return np.stack([floats(table, f"{prefix}_{s}") for s in suffixes], axis=1)
