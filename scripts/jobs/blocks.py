"""Rows by key in a folder that several processes may add to: a Parquet dataset in blocks.

    FOLDER/part-NAME.parquet      rows of the keys that begin with NAME, sorted by key
    FOLDER/.journal/NAME.jsonl    rows not yet in their part, a line each
    FOLDER/.locks/NAME            held (flock) by the process that works on the block

A row is one appended line of a journal as soon as it exists; when all of a block is done, its part
is written anew and replaced in one step. Whoever holds a block's lock is its only writer; the
kernel releases the lock of a process that dies. A journal that a dead process left is taken over by
the next one that claims the block.
"""

import base64
import fcntl
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from armside.sim.records.atomic import atomic

from ..shell.errors import RunFailed, one_line

Row = dict[str, Any]
"""Values by column, `key` and `status` among them; binary columns hold bytes."""
FAILED = "failed"
"""Status of a row without a result."""


@dataclass(frozen=True)
class Blocks:
    """Rows of one schema in a folder, which is made when the first block is claimed."""

    folder: Path
    schema: pa.Schema
    digits: int = 2
    """Of a key, that name its block."""
    expendable: bool = False
    """A damaged part counts as empty: its rows are computed again."""

    def name(self, key: str) -> str:
        """Name of a key's block."""
        return key[: self.digits]

    def part(self, name: str) -> Path:
        """The file of a finished block."""
        return self.folder / f"part-{name}.parquet"

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Rows of all parts, sorted by key; all columns if None.

        Raises RunFailed for a part that cannot be read.
        """
        wanted = self.schema.names if columns is None else list(columns)
        parts = sorted(self.folder.glob("part-*.parquet"))
        if not parts:
            return self.schema.empty_table().select(wanted)
        tables = (_read(part, wanted) for part in parts)
        return pa.concat_tables(tables, promote_options="default")

    def keys(self) -> set[str]:
        """Keys of all rows in parts and journals, while others may write. Raises as `read`."""
        # Journals first: a block that is closed meanwhile moves its rows from there to its part.
        journals = (self.folder / ".journal").glob("*.jsonl")
        kept = {row["key"] for file in journals for row in self.lines(content(file))}
        return kept | set(self.read(["key"])["key"].to_pylist())

    def claim(self, name: str, *, retry_failed: bool = False) -> "Block | None":
        """The block of that name, or None while another process holds it.

        retry_failed: rows without a result do not count as done.

        Raises:
            RunFailed: the folder's file system has no locks, or the block's part is damaged and not
                expendable.
            OSError: the folder cannot be written to.
        """
        locks = self.folder / ".locks"
        locks.mkdir(parents=True, exist_ok=True)
        with ExitStack() as closing:
            lock = os.open(locks / name, os.O_RDWR | os.O_CREAT, 0o644)
            closing.callback(os.close, lock)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return None
            except OSError as error:
                raise RunFailed(
                    f"{self.folder} is on a file system without locks (flock: {error.strerror}); "
                    "give a folder on another one"
                ) from error
            block = Block(self, name, lock, retry_failed=retry_failed)
            closing.pop_all()
            return block

    def lines(self, content: bytes) -> Iterator[Row]:
        """Rows of a journal but for one that is still being written, and damaged ones: they are
        computed again."""
        binary = [field.name for field in self.schema if pa.types.is_binary(field.type)]
        for line in content[: content.rfind(b"\n") + 1].splitlines():
            with suppress(ValueError, KeyError, TypeError):
                row = json.loads(line)
                row |= {name: base64.b64decode(row[name]) for name in binary}
                if isinstance(row["key"], str):
                    yield row

    def misfit(self, row: Row) -> str | None:
        """Why a row does not fit the schema; None if it does."""
        try:
            pa.Table.from_pylist([row], schema=self.schema)
        except (pa.ArrowException, ValueError, TypeError, OverflowError) as error:
            return one_line(error)
        return None


class Block:
    """A block that this process alone may write to, until `close`."""

    def __init__(self, blocks: Blocks, name: str, lock: int, *, retry_failed: bool) -> None:
        """lock: descriptor of the lock that this process holds. Raises as `Blocks.claim`."""
        self.name = name
        self._blocks, self._lock = blocks, lock
        self._part = blocks.part(name)
        self._journal = blocks.folder / ".journal" / f"{name}.jsonl"
        for leftover in blocks.folder.glob(f".{self._part.name}.*.partial"):
            leftover.unlink()
        self._rows = {row["key"]: row for row in self._stored()}
        kept = self._taken_over()
        self._stale = bool(kept)
        self._rows |= {row["key"]: row for row in kept}
        self.failed = {key for key, row in self._rows.items() if row["status"] == FAILED}
        self.done = set(self._rows) - (self.failed if retry_failed else set())
        self._open = None

    def add(self, row: Row) -> None:
        """Keep a row: once this returns, a killed process does not lose it.

        Raises ValueError for a row that the schema cannot hold, which would spoil all of the block,
        and OSError, such as on a full disk.
        """
        if (reason := self._blocks.misfit(row)) is not None:
            raise ValueError(f"a result cannot be kept: {reason}")
        # First: interrupted after its line is written, `close` would drop a row it does not know.
        self._rows[row["key"]] = row
        self._stale = True
        if self._open is None:
            self._journal.parent.mkdir(exist_ok=True)
            self._open = open(self._journal, "ab")  # noqa: SIM115 - closed by close
        line = json.dumps(row, default=lambda value: base64.b64encode(value).decode())
        self._open.write(line.encode() + b"\n")
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
                table = pa.Table.from_pylist(rows, schema=self._blocks.schema)
                with atomic(self._part) as partial:
                    pq.write_table(table, partial)
                    with open(partial, "rb") as file:
                        os.fsync(file.fileno())
                self._journal.unlink(missing_ok=True)
        finally:
            os.close(self._lock)

    def _stored(self) -> list[Row]:
        try:
            return pq.read_table(self._part).to_pylist() if self._part.exists() else []
        except (pa.ArrowException, OSError) as error:
            if not self._blocks.expendable:
                raise damaged(self._part, error) from error
            return []

    def _taken_over(self) -> list[Row]:
        """Rows of the journal that a dead process left. What follows the last whole line was being
        written when it died, and is cut off: only the block's owner may do that."""
        left = content(self._journal)
        if (whole := left.rfind(b"\n") + 1) < len(left):
            os.truncate(self._journal, whole)
        rows = self._blocks.lines(left)
        return [row for row in rows if row.get("status") and self._blocks.misfit(row) is None]


def damaged(part: Path, error: Exception) -> RunFailed:
    """The error of a part that cannot be read: which, and what to do."""
    again = "remove it, and its rows are computed again"
    return RunFailed(f"{part} is damaged ({one_line(error)}); {again}")


def _read(part: Path, columns: list[str]) -> pa.Table:
    """Those of the columns that a part has: one that an older version wrote lacks some."""
    try:
        there = pq.read_schema(part).names
        return pq.read_table(part, columns=[name for name in columns if name in there])
    except (pa.ArrowException, OSError) as error:
        raise damaged(part, error) from error


def content(journal: Path) -> bytes:
    """Bytes of a journal; none where it does not exist, or no longer."""
    try:
        return journal.read_bytes()
    except FileNotFoundError:
        return b""
