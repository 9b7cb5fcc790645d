"""Results of a sweep: each is there once, whatever happened on the way."""

import errno
import json
import os
import tracemalloc

import pyarrow.parquet as pq
import pytest

from armside.scripts.jobs.dataset import dataset, schema
from armside.scripts.jobs.grid import Grid, parse
from armside.scripts.jobs.point import run_grid

from .sweep_engine import Serial, failed, quick


def test_what_is_there_is_not_computed_again(tmp_path):
    few, many = parse(("delta=1:4",), 0), parse(("delta=1:9",), 0)
    assert run_grid(few, dataset(tmp_path), Serial(quick)) == {"done": 3}
    engine = Serial(quick)
    assert run_grid(many, dataset(tmp_path), engine) == {"known": 3, "done": 5}
    assert len(engine.ran) == 5
    keys = dataset(tmp_path).read()["key"].to_pylist()
    assert keys == sorted(point.key for point in many)


def test_failed_configurations_run_again_only_when_asked(tmp_path):
    grid = parse(("delta=1:4",), 0)
    broken = Serial(lambda point: failed(point, "no luck"))
    assert run_grid(grid, dataset(tmp_path), broken) == {"failed": 3}
    assert run_grid(grid, dataset(tmp_path), Serial(quick)) == {"known (failed)": 3}
    assert run_grid(grid, dataset(tmp_path), Serial(quick), retry_failed=True) == {"done": 3}
    assert dataset(tmp_path).read()["status"].to_pylist() == ["done"] * 3


def test_a_result_is_safe_once_it_was_added_and_a_torn_one_is_cut_off(tmp_path):
    first, second, *_ = parse(("delta=1,2",), 0)
    name = dataset(tmp_path).name(first.key)
    block = dataset(tmp_path).claim(name)
    block.add(quick(first))
    journal = tmp_path / ".journal" / f"{name}.jsonl"
    assert journal.read_bytes().endswith(b"\n")  # before its process ends
    assert block._open is not None
    block._open.close()  # its process died here:
    os.close(block._lock)  # the kernel closed its files
    with open(journal, "ab") as file:
        file.write(b'{"key": "half a li')
    assert dataset(tmp_path).keys() == {first.key}
    again = dataset(tmp_path).claim(name)
    assert again.done == {first.key}
    again.add(quick(second))
    rows = journal.read_text(encoding="utf-8").splitlines()
    assert [json.loads(row)["key"] for row in rows] == [first.key, second.key]
    again.close()
    assert dataset(tmp_path).read()["key"].to_pylist() == [first.key, second.key]
    assert not journal.exists()


def test_counting_results_leaves_a_line_that_is_being_written_alone(tmp_path):
    journal = tmp_path / ".journal" / "ab.jsonl"
    journal.parent.mkdir()
    begun, rest = b'{"key": "ab0"}\n{"key": ', b'"ab1"}\n'
    with open(journal, "ab", buffering=0) as file:
        file.write(begun)
        assert dataset(tmp_path).keys() == {"ab0"}
        file.write(rest)
    assert journal.read_bytes() == begun + rest
    assert dataset(tmp_path).keys() == {"ab0", "ab1"}


def test_a_result_is_kept_when_the_interrupt_comes_while_it_is_added(tmp_path):
    (point,) = parse(("delta=1",), 0)
    block = dataset(tmp_path).claim(dataset(tmp_path).name(point.key))

    class Interrupted:
        def write(self, line):
            raise KeyboardInterrupt

        def close(self):
            pass

    block._open = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        block.add(quick(point))
    block.close()
    assert dataset(tmp_path).keys() == {point.key}


def test_a_writer_that_died_between_part_and_journal_leaves_no_row_twice(tmp_path):
    point = next(iter(parse(("delta=1",), 0)))
    run_grid(parse(("delta=1",), 0), dataset(tmp_path), Serial(quick))
    name = dataset(tmp_path).name(point.key)
    line = json.dumps(quick(point)) + "\n"
    (tmp_path / ".journal" / f"{name}.jsonl").write_text(line)
    (tmp_path / f".part-{name}.parquet.123.partial").write_bytes(b"PAR1")
    dataset(tmp_path).claim(name).close()
    assert len(dataset(tmp_path).read()) == 1
    assert not list(tmp_path.glob(".part*"))


def test_a_block_has_one_writer_at_a_time(tmp_path):
    first = dataset(tmp_path).claim("ab")
    assert dataset(tmp_path).claim("ab") is None
    first.close()
    dataset(tmp_path).claim("ab").close()


def test_a_file_system_without_locks_is_one_clear_error(armside, tmp_path, monkeypatch):
    def flock(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", flock)
    status, out, err = armside("sweep gamma=1 --into there")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert "there is on a file system without locks" in err


def test_part_files_can_be_read_while_a_sweep_runs(tmp_path):
    seen = []

    def look(point):
        seen.append(len(dataset(tmp_path).read()))
        return quick(point)

    run_grid(parse(("delta=1:13",), 0), dataset(tmp_path), Serial(look))
    assert seen == sorted(seen)
    assert 0 < seen[-1] < 13
    for part in tmp_path.glob("part-*.parquet"):
        assert pq.read_schema(part).equals(schema())


def test_results_are_not_kept_in_memory(tmp_path):
    def peak(n):
        grid = Grid({"speed": (60.0,), "seed": range(n)})
        large = Serial(lambda point: quick(point) | {"arm_rms": [0.5] * 2000})
        tracemalloc.start()
        run_grid(grid, dataset(tmp_path / str(n)), large)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    peak(40)  # imports
    few, many, resumed = peak(20), peak(120), peak(120)
    quarter = 100 * 2000 * 8 / 4  # of what the further results alone would take
    assert many < few + quarter
    assert resumed < few + quarter
