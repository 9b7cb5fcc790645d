"""The dataset of a sweep: one row for each configuration of `armside laser`.

    FOLDER/.rows/AB/KEY.json     rows as they come, a file each, AB the first digits of the key
    FOLDER/part-0.parquet        all rows, gathered at the end of a sweep and every few minutes

Rows stay where they came, and the Parquet file is made of them: whatever happens to a process, the
next one to gather has all of them.
"""

import json
import time
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache, cached_property
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from armside.sim.evaluation.motion_error import MotionError
from armside.sim.records.atomic import atomic, write_whole

from ..cutting.options import LaserCfg
from ..shell.errors import RunFailed, one_line
from .queue import FAILED, POLL, Claims

Row = dict[str, Any]
"""Values by column, `key` and `status` among them."""

EVERY = 300.0
"""[s], from one gathering of rows to the next while a sweep runs."""
_CHUNK = 16
"""Rows that are Python's objects at a time."""
_PER_RUN = (
    *("arm_rms", "arm_maxdev", "arm_rms_true", "arm_maxdev_true"),
    *(field.name for field in fields(MotionError) if field.name not in MotionError.PER_STOP),
)
_LISTS = ("motor_inf", "motor_two", *MotionError.PER_STOP)


class Dataset:
    """Rows by key in a folder that several processes may add to; made with the first row."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._gathered = time.monotonic()

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Rows that were gathered, sorted by key; all columns if None. Those that an older version
        lacks are empty. Raises RunFailed for a file that cannot be read."""
        return _read(self._parts(), schema().names if columns is None else list(columns))

    def keys(self) -> set[str]:
        """Keys of all rows, while others may write. Raises as `read`."""
        return {file.stem for file in self._files()} | set(self.read(["key"])["key"].to_pylist())

    def status(self, key: str) -> str | None:
        """Status of a row; None where there is none. Raises as `read`."""
        row = _row(self._file(key))
        return self._before.get(key) if row is None else row["status"]

    def add(self, row: Row) -> None:
        """Store a row: once this returns, a killed process does not lose it. Raises ValueError for
        a row that the schema cannot hold, and OSError, such as on a full disk."""
        if (reason := _misfit(row)) is not None:
            raise ValueError(f"a result cannot be kept: {reason}")
        file = self._file(row["key"])
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, json.dumps(row))
        if time.monotonic() > self._gathered + EVERY:
            self.gather()

    def keep(self, key: str, job: Any, outcome: Row | Exception) -> str:
        """See `queue.Results`: of a job that fails, that is the result."""
        if not isinstance(outcome, Exception):
            try:
                self.add(outcome)
                return outcome["status"]
            except ValueError as error:  # it fits no dataset, and fails alone
                outcome = error
        with suppress(ValueError):
            self.add(job.failed(outcome))
        return FAILED

    def gather(self) -> None:
        """Bring the Parquet file up to all rows. Raises OSError, and as `read`."""
        if not self._files():
            return
        claims, target = Claims(self.folder), self.folder / "part-0.parquet"
        while not claims.take(target.stem):  # another process gathers, and may lack our last rows
            time.sleep(POLL)
        try:
            parts, rows = self._parts(), _table(self._files())
            older = _read(parts, schema().names)
            older = older.filter(pc.invert(pc.is_in(older["key"], rows["key"])))  # pyright: ignore[reportAttributeAccessIssue]
            with atomic(target) as partial:
                pq.write_table(pa.concat_tables([rows, older]).sort_by("key"), partial)
            for part in set(parts) - {target}:  # of an older version
                part.unlink()
        finally:
            claims.drop()
        self._gathered = time.monotonic()

    @cached_property
    def _before(self) -> dict[str, str]:
        """Status of the gathered rows when it was first asked for."""
        found = self.read(["key", "status"])
        return dict(zip(found["key"].to_pylist(), found["status"].to_pylist(), strict=True))

    def _parts(self) -> list[Path]:
        return sorted(self.folder.glob("part-*.parquet"))

    def _file(self, key: str) -> Path:
        return self.folder / ".rows" / key[:2] / f"{key}.json"

    def _files(self) -> list[Path]:
        return sorted(self.folder.glob(".rows/*/*.json"))


@cache
def schema() -> pa.Schema:
    """Key, outcome, the options of `armside laser`, error that a twin predicts of the first run,
    and a list over the runs for each measure."""
    hints, numbers = get_type_hints(LaserCfg), pa.list_(pa.float64())
    columns = [
        *((name, pa.string()) for name in ("key", "status", "error")),
        ("seed", pa.int64()),
        *((field.name, _arrow(hints[field.name])) for field in fields(LaserCfg)),
        ("predicted", pa.float64()),
        ("reached_speed", pa.float64()),
        ("limits_hit", pa.int64()),
        ("notes", pa.list_(pa.string())),
        *((name, numbers) for name in _PER_RUN),
        *((name, pa.list_(numbers)) for name in _LISTS),
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
        **{name: [row[name].tolist() for row in rows] for name in _LISTS},
    }


def first_error(rows: Dataset, keys: Iterable[str]) -> str | None:
    """Error of the first of these configurations that has failed; None if none has. Raises as
    `Dataset.read`."""
    found = rows.read(["key", "status", "error"]).to_pylist()
    errors = {row["key"]: row["error"] for row in found if row["status"] == FAILED}
    return next((errors[key] for key in keys if key in errors), None)


def noted(rows: Dataset, keys: Collection[str]) -> tuple[int, str]:
    """Number of these configurations that have notes, and the most common first note; "" if none
    has. Raises as `Dataset.read`."""
    found = rows.read(["key", "notes"]).to_pylist()
    firsts = Counter(row["notes"][0] for row in found if row["key"] in keys and row["notes"])
    return firsts.total(), max(firsts, key=firsts.__getitem__, default="")


def _arrow(hint: Any) -> pa.DataType:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        parts = [part for part in inner if part is not type(None)]
        return _arrow(parts[0]) if len(parts) == 1 else pa.string()
    if origin is tuple:
        return pa.list_(_arrow(inner[0]))
    if origin is Literal:
        return _arrow(type(inner[0]))
    return {float: pa.float64(), int: pa.int64(), bool: pa.bool_()}.get(hint, pa.string())


def _row(file: Path) -> Row | None:
    """The row of a file; None where there is none, or a damaged one: it is computed again."""
    try:
        row = json.loads(file.read_bytes())
        return row if row["key"] == file.stem and row["status"] else None
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _misfit(row: Row) -> str | None:
    """Why a row does not fit the schema; None if it does."""
    try:
        pa.Table.from_pylist([row], schema=schema())
    except (pa.ArrowException, ValueError, TypeError, OverflowError) as error:
        return one_line(error)
    return None


def _table(files: list[Path]) -> pa.Table:
    """Rows of files. Raises RunFailed for one that fits no column, such as another version's."""
    tables = [schema().empty_table()]
    for i in range(0, len(files), _CHUNK):
        found = {file: row for file in files[i : i + _CHUNK] if (row := _row(file)) is not None}
        try:
            tables.append(pa.Table.from_pylist(list(found.values()), schema=schema()))
        except (pa.ArrowException, ValueError, TypeError, OverflowError) as error:
            file, reason = next((f, said) for f, row in found.items() if (said := _misfit(row)))
            again = "remove it, and it is computed again"
            raise RunFailed(f"{file} does not fit ({reason}); {again}") from error
    return pa.concat_tables(tables)


def _read(parts: list[Path], columns: list[str]) -> pa.Table:
    """Rows of Parquet files, sorted by key. Raises RunFailed for a damaged one."""
    try:
        of = ds.dataset(list(map(str, parts)), schema(), format="parquet")
        whole = of.to_table(columns=list(dict.fromkeys(["key", *columns])))
    except (pa.ArrowException, OSError) as error:
        again = "remove it, and its rows are gathered or computed again"
        raise RunFailed(f"a Parquet file is damaged: {one_line(error)}; {again}") from error
    return whole.sort_by("key").select(columns)
