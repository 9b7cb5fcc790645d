"""Results of a sweep: each is there once, whatever happened on the way."""

import errno
import json
import tracemalloc
from typing import Literal

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from armside.scripts.jobs.dataset import Dataset, _arrow, schema
from armside.scripts.jobs.grid import Grid, parse, run_grid
from armside.scripts.jobs.queue import Claims
from armside.scripts.shell.errors import RunFailed

from .sweep_engine import Serial, failed, quick


def test_what_is_there_is_not_computed_again(tmp_path):
    few, many = parse(("delta=1:4",), 0), parse(("delta=1:9",), 0)
    assert run_grid(few, Dataset(tmp_path), Serial(quick)) == {"done": 3}
    engine = Serial(quick)
    assert run_grid(many, Dataset(tmp_path), engine) == {"known": 3, "done": 5}
    assert len(engine.ran) == 5
    keys = Dataset(tmp_path).read()["key"].to_pylist()
    assert keys == sorted(point.key for point in many)


def test_failed_configurations_run_again_only_when_asked(tmp_path):
    grid = parse(("delta=1:4",), 0)
    broken = Serial(lambda point: failed(point, "no luck"))
    assert run_grid(grid, Dataset(tmp_path), broken) == {"failed": 3}
    assert run_grid(grid, Dataset(tmp_path), Serial(quick)) == {"known (failed)": 3}
    assert run_grid(grid, Dataset(tmp_path), Serial(quick), retry_failed=True) == {"done": 3}
    assert Dataset(tmp_path).read()["status"].to_pylist() == ["done"] * 3


def test_a_result_is_safe_once_it_was_added(tmp_path):
    first, second = parse(("delta=1,2",), 0)
    rows = Dataset(tmp_path)
    rows.add(quick(first))  # its process is killed here
    assert Dataset(tmp_path).keys() == {first.key}
    assert Dataset(tmp_path).status(first.key) == "done"
    assert Dataset(tmp_path).status(second.key) is None
    grid = parse(("delta=1,2",), 0)
    assert run_grid(grid, Dataset(tmp_path), Serial(quick)) == {"known": 1, "done": 1}
    keys = Dataset(tmp_path).read()["key"].to_pylist()
    assert keys == sorted([first.key, second.key])


def test_a_result_whose_writing_was_interrupted_is_computed_again(tmp_path, monkeypatch):
    (point,) = parse(("delta=1",), 0)

    def interrupted(*_):
        raise KeyboardInterrupt

    row = quick(point)
    with monkeypatch.context() as patched:
        patched.setattr("pathlib.Path.replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            Dataset(tmp_path).add(row)
    assert Dataset(tmp_path).keys() == set()
    assert run_grid([point], Dataset(tmp_path), Serial(quick)) == {"done": 1}


def test_rows_that_were_gathered_twice_are_there_once(tmp_path):
    grid = parse(("delta=1,2",), 0)
    run_grid(grid, Dataset(tmp_path), Serial(quick))
    whole = Dataset(tmp_path).read()
    (tmp_path / "part-0.parquet").rename(tmp_path / "part-ab.parquet")  # of an older version
    Dataset(tmp_path).gather()
    assert Dataset(tmp_path).read().equals(whole)
    assert [part.name for part in tmp_path.glob("part-*")] == ["part-0.parquet"]


def test_a_job_has_one_process_at_a_time(tmp_path):
    ours, theirs = Claims(tmp_path), Claims(tmp_path)
    assert ours.take("ab")
    assert not theirs.take("ab")
    ours.drop("ab")
    assert theirs.take("ab")
    theirs.drop()
    assert not list((tmp_path / ".claims").iterdir())


def test_a_file_system_without_locks_will_do(armside, tmp_path, monkeypatch):
    def flock(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", flock)
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(quick))
    status, out, err = armside("sweep delta=1:4 --into there")
    assert (status, err) == (0, "")
    assert "3 done" in out


def test_results_can_be_read_while_a_sweep_runs(tmp_path, monkeypatch):
    monkeypatch.setattr("armside.scripts.jobs.dataset.EVERY", -1.0)
    seen = []

    def look(point):
        seen.append(len(Dataset(tmp_path).read()))
        return quick(point)

    run_grid(parse(("delta=1:13",), 0), Dataset(tmp_path), Serial(look))
    assert seen == list(range(12))
    assert pq.read_schema(tmp_path / "part-0.parquet").equals(schema())


def test_results_are_not_kept_in_memory(tmp_path):
    def peak(n):
        grid = Grid({"speed": (60.0,), "seed": range(n)})
        large = Serial(lambda point: quick(point) | {"arm_rms": [0.5] * 2000})
        tracemalloc.start()
        run_grid(grid, Dataset(tmp_path / str(n)), large)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    peak(40)  # imports
    few, many, resumed = peak(40), peak(140), peak(140)
    quarter = 100 * 2000 * 8 / 4  # of what the further results alone would take
    assert many < few + quarter
    assert resumed < few + quarter


@pytest.mark.parametrize("value", [2**63, "text", [1], b"\xff"])
def test_a_row_that_no_column_can_hold_fails_alone(tmp_path, value):
    def spoilt(point):
        (delta,) = point.options["delta"]
        return quick(point) | ({"limits_hit": value} if delta == 2 else {})

    counts = run_grid(parse(("delta=1:4",), 0), Dataset(tmp_path), Serial(spoilt))
    assert counts == {"done": 2, "failed": 1}
    rows = {row["delta"][0]: row for row in Dataset(tmp_path).read().to_pylist()}
    assert [rows[delta]["status"] for delta in (1, 2, 3)] == ["done", "failed", "done"]
    assert "cannot be kept" in rows[2]["error"]


def test_a_row_that_cannot_even_be_kept_as_failed_spoils_no_other(tmp_path):
    points = list(Grid({"robot": ("large", "\ud800"), "seed": range(2)}))
    assert run_grid(points, Dataset(tmp_path), Serial(quick)) == {"done": 2, "failed": 2}
    assert len(Dataset(tmp_path).read()) == 2


DAMAGED = [b"{", b"[]", b"null", b'{"key": 3}', b'{"status": "done"}', b"\xff\xfe", b""]


@pytest.mark.parametrize("content", DAMAGED)
def test_a_damaged_row_is_computed_again(tmp_path, content):
    grid = list(parse(("delta=1,2",), 0))
    rows = Dataset(tmp_path)
    for point in grid:
        rows.add(quick(point))
    rows._file(grid[0].key).write_bytes(content)
    assert run_grid(grid, Dataset(tmp_path), Serial(quick)) == {"known": 1, "done": 1}
    assert json.loads(rows._file(grid[0].key).read_bytes())["status"] == "done"
    assert len(Dataset(tmp_path).read()) == 2


def test_a_damaged_file_is_named_with_what_to_do(tmp_path):
    grid = list(parse(("delta=1,2",), 0))
    run_grid(grid, Dataset(tmp_path), Serial(quick))
    (tmp_path / "part-0.parquet").write_bytes(b"PAR1")
    rows = Dataset(tmp_path)
    for reading in (rows.read, rows.keys, rows.gather):
        with pytest.raises(RunFailed, match=r"damaged: .*part-0\.parquet.*; remove it"):
            reading()
    (tmp_path / "part-0.parquet").unlink()
    assert run_grid(grid, Dataset(tmp_path), Serial(quick)) == {"known": 2}
    assert len(Dataset(tmp_path).read()) == 2


def test_a_row_of_another_version_is_named_with_what_to_do(tmp_path):
    (point,) = parse(("delta=1",), 0)
    file = Dataset(tmp_path)._file(point.key)
    file.parent.mkdir(parents=True)
    file.write_text(json.dumps(quick(point) | {"limits_hit": "many"}))
    with pytest.raises(RunFailed, match=rf"{point.key}.json does not fit .*; remove it"):
        run_grid([point], Dataset(tmp_path), Serial(quick))


@pytest.mark.parametrize(
    ("hint", "kind"),
    [
        (float, pa.float64()),
        (float | None, pa.float64()),
        (int | str, pa.string()),
        (bool, pa.bool_()),
        (Literal["a", "b"], pa.string()),
        (tuple[int, ...], pa.list_(pa.int64())),
    ],
)
def test_a_column_has_the_type_of_its_field_whether_or_not_it_may_be_empty(hint, kind):
    assert _arrow(hint) == kind
