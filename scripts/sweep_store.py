"""Results of sweeps in a folder: a Parquet dataset that survives whatever happens to its writers.

    FOLDER/part-00.parquet ... part-ff.parquet    rows of the keys that begin so, sorted by key
    FOLDER/.journal/00.jsonl                      results that are not in their part yet
    FOLDER/.locks/00                              held (flock) by the sweep that works on a block

A result is one appended line of a journal as soon as it exists; when all of a block is done, its
part is written anew and replaced in one step. Whoever holds a block's lock is its only writer; the
kernel releases the lock of a process that dies. A journal that a dead process left is taken over by
the next one that claims the block.
"""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import pyarrow as pa
import pyarrow.parquet as pq

from sim.atomic import atomic

from .laser import LaserCfg

Row = dict[str, Any]

_PER_RUN = ("arm_rms", "arm_maxdev", "arm_rms_true", "arm_maxdev_true")
_PER_MOTOR = ("motor_inf", "motor_two")


def block_of(key: str) -> str:
    """The block that a key belongs to."""
    return key[:2]


def schema() -> pa.Schema:
    """Key, outcome, the options of `armside laser`, and a list over the runs for each measure."""
    hints = get_type_hints(LaserCfg, include_extras=False)
    options = [(f.name, _arrow(hints[f.name])) for f in fields(LaserCfg)]
    return pa.schema(
        [
            ("key", pa.string()),
            ("status", pa.string()),
            ("error", pa.string()),
            ("seed", pa.int64()),
            *options,
            ("reached_speed", pa.float64()),
            ("limits_hit", pa.int64()),
            *((name, pa.list_(pa.float64())) for name in _PER_RUN),
            *((name, pa.list_(pa.list_(pa.float64()))) for name in _PER_MOTOR),
            ("version", pa.string()),
            ("code", pa.string()),
        ]
    )


def measures(results: Mapping[str, Any]) -> Row:
    """The columns of a row that come from the results of a laser run."""
    rows = results["iterations"]
    return {
        "reached_speed": float(results["reached_speed"]),
        "limits_hit": len(results["limits_hit"]),
        **{name: [float(row[name]) for row in rows] for name in _PER_RUN},
        **{name: [row[name].tolist() for row in rows] for name in _PER_MOTOR},
    }


def read(folder: Path) -> pa.Table:
    """All rows of a folder's parts, sorted by key."""
    parts = sorted(folder.glob("part-*.parquet"))
    tables = [pq.read_table(part) for part in parts]
    return pa.concat_tables(tables, promote_options="default") if tables else schema().empty_table()


def rows_kept(folder: Path) -> int:
    """Results that a resumed sweep would find, in parts and journals."""
    keys = set(read(folder)["key"].to_pylist())
    for journal in (folder / ".journal").glob("*.jsonl"):
        keys |= {row["key"] for row in _lines(journal)}
    return len(keys)


class Block:
    """A block that this process alone may write to, until `close`."""

    def __init__(self, folder: Path, name: str, lock: int, *, retry_failed: bool) -> None:
        self.name = name
        self._lock = lock
        self._part = folder / f"part-{name}.parquet"
        self._journal = folder / ".journal" / f"{name}.jsonl"
        for leftover in folder.glob(f".part-{name}.parquet.*.partial"):
            leftover.unlink()
        self._rows = {row["key"]: row for row in self._stored()}
        kept = list(_lines(self._journal))
        self._stale = bool(kept)
        self._rows |= {row["key"]: row for row in kept}
        again = [key for key, row in self._rows.items() if row["status"] == "failed"]
        self.done = set(self._rows) - set(again if retry_failed else ())
        self._open = None

    def add(self, row: Row) -> None:
        """Keep a result: once this returns, a killed process does not lose it."""
        if self._open is None:
            self._journal.parent.mkdir(exist_ok=True)
            self._open = open(self._journal, "ab", buffering=0)  # noqa: SIM115 - closed by close
        self._open.write(json.dumps(row).encode() + b"\n")
        self._rows[row["key"]] = row
        self._stale = True

    def close(self) -> None:
        """Write the part anew if there is something new, then let others have the block."""
        try:
            if self._open is not None:
                self._open.close()
            if self._stale:
                rows = [self._rows[key] for key in sorted(self._rows)]
                with atomic(self._part) as partial:
                    pq.write_table(pa.Table.from_pylist(rows, schema=schema()), partial)
                    with open(partial, "rb") as file:
                        os.fsync(file.fileno())
                self._journal.unlink(missing_ok=True)
        finally:
            os.close(self._lock)

    def _stored(self) -> list[Row]:
        return pq.read_table(self._part).to_pylist() if self._part.exists() else []


@dataclass(frozen=True)
class Store:
    """A folder of results that several sweeps may work on at once."""

    folder: Path

    def claim(self, name: str, *, retry_failed: bool = False) -> Block | None:
        """The block of that name, or None while another sweep holds it."""
        locks = self.folder / ".locks"
        locks.mkdir(parents=True, exist_ok=True)
        lock = os.open(locks / name, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            return None
        try:
            return Block(self.folder, name, lock, retry_failed=retry_failed)
        except BaseException:
            os.close(lock)
            raise


def _lines(journal: Path) -> Iterator[Row]:
    """Rows of a journal. What follows the last whole line was being written when its writer died:
    it is cut off."""
    if not journal.exists():
        return
    content = journal.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole < len(content):
        os.truncate(journal, whole)
    for line in content[:whole].splitlines():
        yield json.loads(line)


def _arrow(hint: Any) -> pa.DataType:
    """The column type of an option."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _arrow(inner[0])
    if origin in (Union, UnionType):
        return _arrow(next(part for part in inner if part is not type(None)))
    if origin is tuple:
        return pa.list_(_arrow(inner[0]))
    if origin is Literal:
        return _arrow(type(inner[0]))
    return {float: pa.float64(), int: pa.int64(), bool: pa.bool_()}.get(hint, pa.string())
