"""Results of sweeps in a folder: a Parquet dataset that survives whatever happens to its writers.

    FOLDER/part-00.parquet ... part-ff.parquet    rows of the keys that begin so, sorted by key
    FOLDER/.journal/00.jsonl                      results not yet in their part, a line each
    FOLDER/.locks/00                              held (flock) by the sweep that works on a block

A result is one appended line of a journal as soon as it exists; when all of a block is done, its
part is written anew and replaced in one step. Whoever holds a block's lock is its only writer; the
kernel releases the lock of a process that dies. A journal that a dead process left is taken over by
the next one that claims the block.
"""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import pyarrow as pa
import pyarrow.parquet as pq

from armside.sim.records.atomic import atomic

from ..commands.laser import LaserCfg
from ..shell.errors import RunFailed

Row = dict[str, Any]
FAILED = "failed"
"""Status of a configuration without a result."""

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


def read(folder: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """Rows of a folder's parts, sorted by key; all columns if None.

    Raises OSError or pyarrow.ArrowInvalid for a part that cannot be read.
    """
    parts = sorted(folder.glob("part-*.parquet"))
    wanted = None if columns is None else list(columns)
    if not parts:
        return schema().empty_table().select(wanted or schema().names)
    tables = [pq.read_table(part, columns=wanted) for part in parts]
    return pa.concat_tables(tables, promote_options="default")


def keys_kept(folder: Path) -> set[str]:
    """Keys of the results that a resumed sweep would find, in parts and journals.

    Others may be writing to the folder. Raises OSError for a file that cannot be read.
    """
    # Journals first: a block that is closed meanwhile moves its rows from there to its part.
    journals = (folder / ".journal").glob("*.jsonl")
    kept = {row["key"] for journal in journals for row in _whole_lines(_content(journal))}
    return kept | set(read(folder, ["key"])["key"].to_pylist())


def failures(folder: Path) -> dict[str, str]:
    """Error of each failed configuration in a folder's parts, by key. Raises as `read`."""
    rows = read(folder, ["key", "status", "error"]).to_pylist()
    return {row["key"]: row["error"] for row in rows if row["status"] == FAILED}


class Block:
    """A block that this process alone may write to, until `close`."""

    def __init__(self, folder: Path, name: str, lock: int, *, retry_failed: bool) -> None:
        """lock: descriptor of the lock that this process holds. Raises OSError or
        pyarrow.ArrowInvalid for files that cannot be read."""
        self.name = name
        self._lock = lock
        self._part = folder / f"part-{name}.parquet"
        self._journal = folder / ".journal" / f"{name}.jsonl"
        for leftover in folder.glob(f".part-{name}.parquet.*.partial"):
            leftover.unlink()
        self._rows = {row["key"]: row for row in self._stored()}
        kept = self._taken_over()
        self._stale = bool(kept)
        self._rows |= {row["key"]: row for row in kept}
        self.failed = {key for key, row in self._rows.items() if row["status"] == FAILED}
        self.done = set(self._rows) - (self.failed if retry_failed else set())
        self._open = None

    def add(self, row: Row) -> None:
        """Keep a result: once this returns, a killed process does not lose it.

        Raises OSError, such as on a full disk.
        """
        # First: interrupted after its line is written, `close` would drop a row it does not know.
        self._rows[row["key"]] = row
        self._stale = True
        if self._open is None:
            self._journal.parent.mkdir(exist_ok=True)
            self._open = open(self._journal, "ab")  # noqa: SIM115 - closed by close
        self._open.write(json.dumps(row).encode() + b"\n")
        self._open.flush()

    def close(self) -> None:
        """Write the part anew if there is something new, then let others have the block.

        Raises OSError, such as on a full disk; the journal then stays.
        """
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

    def _taken_over(self) -> list[Row]:
        """Rows of the journal that a dead process left. What follows the last whole line was being
        written when it died, and is cut off: only the block's owner may do that."""
        content = _content(self._journal)
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            os.truncate(self._journal, whole)
        return list(_whole_lines(content))


@dataclass(frozen=True)
class Store:
    """A folder of results that several sweeps may work on at once."""

    folder: Path

    def claim(self, name: str, *, retry_failed: bool = False) -> Block | None:
        """The block of that name, or None while another sweep holds it.

        Raises:
            RunFailed: the folder's file system has no locks.
            OSError: the folder cannot be written to.
            pyarrow.ArrowInvalid: the block's part is damaged.
        """
        locks = self.folder / ".locks"
        locks.mkdir(parents=True, exist_ok=True)
        lock = os.open(locks / name, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            return None
        except OSError as error:
            os.close(lock)
            raise RunFailed(
                f"{self.folder} is on a file system without locks (flock: {error.strerror}); "
                "give --into on another one"
            ) from error
        try:
            return Block(self.folder, name, lock, retry_failed=retry_failed)
        except BaseException:
            os.close(lock)
            raise


def _content(journal: Path) -> bytes:
    """What is in a journal; nothing where there is none, or no longer."""
    try:
        return journal.read_bytes()
    except FileNotFoundError:
        return b""


def _whole_lines(content: bytes) -> Iterator[Row]:
    """Rows of a journal but for one that is still being written."""
    for line in content[: content.rfind(b"\n") + 1].splitlines():
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
