"""The dataset of a sweep: one row for each configuration of `armside laser`."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import pyarrow as pa

from ..cutting.options import LaserCfg
from .blocks import FAILED, Blocks, Row

_PER_RUN = ("arm_rms", "arm_maxdev", "arm_rms_true", "arm_maxdev_true")
_PER_MOTOR = ("motor_inf", "motor_two")


def dataset(folder: Path) -> Blocks:
    """The dataset in a folder: 256 blocks."""
    return Blocks(folder, schema())


def schema() -> pa.Schema:
    """Key, outcome, the options of `armside laser`, error that a twin predicts of the first run,
    and a list over the runs for each measure."""
    hints = get_type_hints(LaserCfg, include_extras=False)
    options = [(f.name, _arrow(hints[f.name])) for f in fields(LaserCfg)]
    numbers = pa.list_(pa.float64())
    columns = [
        *((name, pa.string()) for name in ("key", "status", "error")),
        ("seed", pa.int64()),
        *options,
        ("predicted", pa.float64()),
        ("reached_speed", pa.float64()),
        ("limits_hit", pa.int64()),
        ("notes", pa.list_(pa.string())),
        *((name, numbers) for name in _PER_RUN),
        *((name, pa.list_(numbers)) for name in _PER_MOTOR),
        *((name, pa.string()) for name in ("version", "code")),
    ]
    return pa.schema(columns)


def measures(results: Mapping[str, Any]) -> Row:
    """The columns of a row that come from the results of a laser run."""
    rows, predicted = results["iterations"], results.get("predicted")
    return {
        "predicted": None if predicted is None else predicted["arm_rms"],
        "reached_speed": float(results["reached_speed"]),
        "limits_hit": len(results["limits_hit"]),
        "notes": [note.line for note in results["notes"]],
        **{name: [float(row[name]) for row in rows] for name in _PER_RUN},
        **{name: [row[name].tolist() for row in rows] for name in _PER_MOTOR},
    }


def first_error(rows: Blocks, keys: Iterable[str]) -> str | None:
    """Error of the first of these configurations that has failed; None if none has. Raises as
    `Blocks.read`."""
    found = rows.read(["key", "status", "error"]).to_pylist()
    errors = {row["key"]: row["error"] for row in found if row["status"] == FAILED}
    return next((errors[key] for key in keys if key in errors), None)


def noted(rows: Blocks, keys: Collection[str]) -> tuple[int, str]:
    """Number of these configurations that have notes, and the most common first note; "" if none
    has. Raises as `Blocks.read`."""
    found = rows.read(["key", "notes"]).to_pylist()
    firsts = Counter(row["notes"][0] for row in found if row["key"] in keys and row.get("notes"))
    return firsts.total(), next((text for text, _ in firsts.most_common(1)), "")


def _arrow(hint: Any) -> pa.DataType:
    """The column type of an option."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _arrow(inner[0])
    if origin in (Union, UnionType):
        parts = [part for part in inner if part is not type(None)]
        return _arrow(parts[0]) if len(parts) == 1 else pa.string()
    if origin is tuple:
        return pa.list_(_arrow(inner[0]))
    if origin is Literal:
        return _arrow(type(inner[0]))
    return {float: pa.float64(), int: pa.int64(), bool: pa.bool_()}.get(hint, pa.string())
