"""Stored rows: one that fits no dataset fails alone, and what is damaged is named or made again."""

import json
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.scripts.jobs.blocks import Blocks
from armside.scripts.jobs.queue import Queue
from armside.scripts.jobs.store import Store, digest
from armside.scripts.shell.errors import RunFailed

SCHEMA = pa.schema([("key", pa.string()), ("status", pa.string()), ("value", pa.int64())])


def row(key, value=1, status="done"):
    return {"key": key, "status": status, "value": value}


class Inline:
    """Engine that runs one task at a time."""

    def __init__(self):
        self.tasks = []

    @property
    def room(self):
        return 1 - len(self.tasks)

    @property
    def busy(self):
        return bool(self.tasks)

    def submit(self, tag, function, item):
        self.tasks.append((tag, function(item)))

    def collect(self):
        return [self.tasks.pop()]

    def close(self):
        pass


@dataclass(frozen=True)
class Value:
    value: object
    cost: float = 1.0

    def run(self):
        return self.value


def complete(blocks, values):
    """Bring a folder up to values by key."""

    def made(key, outcome):
        if isinstance(outcome, Exception):
            return row(key, None, "failed")
        return row(key, outcome)

    queue = Queue(blocks=blocks, engine=Inline(), row=made)
    return queue.complete({key: Value(value) for key, value in values.items()})


@pytest.mark.parametrize("value", [2**63, "text", [1], b"\xff"])
def test_a_row_that_no_column_can_hold_fails_alone(tmp_path, value):
    blocks = Blocks(tmp_path, SCHEMA)
    counts = complete(blocks, {"aa1": 1, "aa2": value, "aa3": 3})
    assert counts == {"done": 2, "failed": 1}
    assert blocks.read()["value"].to_pylist() == [1, None, 3]
    assert blocks.read()["status"].to_pylist() == ["done", "failed", "done"]


def test_a_row_that_cannot_even_be_kept_as_failed_spoils_no_other(tmp_path):
    blocks = Blocks(tmp_path, SCHEMA)
    queue = Queue(blocks=blocks, engine=Inline(), row=lambda key, value: row(key, value))
    jobs = {f"aa{i}": Value(value) for i, value in enumerate((1, 2**63, 3))}
    assert queue.complete(jobs) == {"done": 2, "failed": 1}
    assert blocks.read()["value"].to_pylist() == [1, 3]


DAMAGED = [
    b"{",
    b"[]",
    b"null",
    b'{"key": 3}',
    b'{"status": "done"}',
    b"\xff\xfe",
    b'{"key": "aa9"}',
]


@pytest.mark.parametrize("line", DAMAGED)
def test_a_damaged_line_of_a_journal_is_computed_again(tmp_path, line):
    journal = tmp_path / ".journal" / "aa.jsonl"
    journal.parent.mkdir()
    journal.write_bytes(json.dumps(row("aa1")).encode() + b"\n" + line + b"\n")
    blocks = Blocks(tmp_path, SCHEMA)
    assert complete(blocks, {"aa1": 7, "aa9": 9}) == {"known": 1, "done": 1}
    assert blocks.read()["value"].to_pylist() == [1, 9]


def test_a_damaged_part_is_named_with_what_to_do(tmp_path):
    blocks = Blocks(tmp_path, SCHEMA)
    complete(blocks, {"aa1": 1, "bb1": 2})
    blocks.part("aa").write_bytes(b"PAR1")
    for reading in (blocks.read, blocks.keys, lambda: blocks.claim("aa")):
        with pytest.raises(RunFailed, match=r"part-aa\.parquet is damaged .*; remove it"):
            reading()
    blocks.part("aa").unlink()
    assert complete(blocks, {"aa1": 1, "bb1": 2}) == {"done": 1, "known": 1}


@dataclass(frozen=True)
class Job:
    cost: float = 1.0

    def run(self):
        return {"a": np.random.default_rng(0).random(1000)}


def damage_footer(file):
    file.write_bytes(file.read_bytes()[:-20])


def damage_data(file):
    content = bytearray(file.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 40] = bytes(40)
    file.write_bytes(content)


def damage_arrays(file):
    packed = [{"key": digest(Job()), "status": "done", "arrays": b"PK no zip"}]
    pq.write_table(pa.Table.from_pylist(packed), file)


def empty(file):
    file.write_bytes(b"")


@pytest.mark.parametrize("damage", [damage_footer, damage_data, damage_arrays, empty])
def test_a_damaged_result_counts_as_none_wherever_it_is_damaged(tmp_path, damage):
    store, job = Store(tmp_path), Job()
    store.save(job, job.run())
    assert store.holds(job)
    damage(store.file(job))
    assert not store.holds(job)
    store.save(job, job.run())
    assert np.array_equal(store.load(job)["a"], job.run()["a"])
