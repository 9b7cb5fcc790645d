"""`armside sweep`: what is asked for is there once, whatever happened on the way."""

import importlib
import json
import os
import random
import signal
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from scripts.errors import InputError
from scripts.laser import LaserCfg, run
from scripts.sweep import run_grid
from scripts.sweep_engine import Local, failed, simulate
from scripts.sweep_grid import Grid, Point, key_of, parse
from scripts.sweep_store import Store, block_of, read, rows_kept, schema

AXES = ("gamma=0.5,0.9", "pose=p1,p9", "speed=60", "iterations=1", "seed=0:2")
"""Half of them can be done: there is no p9."""
ROOT = Path(__file__).parent.parent.parent


class Serial:
    """An engine that runs a point when it is asked for results."""

    def __init__(self, function=simulate):
        self.function, self.queue, self.ran = function, [], []

    @property
    def room(self):
        return 2 - len(self.queue)

    @property
    def busy(self):
        return bool(self.queue)

    def submit(self, point):
        self.queue.append(point)

    def collect(self):
        point = self.queue.pop(0)
        self.ran.append(point.key)
        return [self.function(point)]

    def close(self):
        self.queue.clear()


def quick(point):
    """A result without an experiment."""
    return failed(point, "not run") | {"status": "done", "error": None}


def test_a_grid_is_every_combination_under_one_key_each():
    grid = parse(("gamma=0.5,0.9", "delta=3,6,9", "seed=2:5"), 0)
    points = list(grid)
    assert len(points) == len(grid) == 18
    assert len({point.key for point in points}) == 18
    assert points[0].options == {"gamma": (0.5,), "delta": (3,)}
    assert [point.seed for point in points[:3]] == [2, 3, 4]


def test_a_key_is_that_of_the_whole_configuration():
    assert key_of({"gamma": (0.9,)}, 0) == key_of({}, 0)  # the default
    assert key_of({"gamma": (0.8,)}, 0) != key_of({}, 0)
    assert key_of({}, 1) != key_of({}, 0)


def test_values_of_six_motors_and_options_with_dashes_are_read():
    grid = parse(("gamma=0.9/0.9/0.8/0.8/0.7/0.7", "friction-spread=1,2"), 0)
    first = next(iter(grid))
    assert first.options == {"gamma": (0.9, 0.9, 0.8, 0.8, 0.7, 0.7), "friction_spread": 1.0}


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ((), "at least one axis"),
        (("gamma",), "option=value,value"),
        (("gama=1",), "Unknown option of laser 'gama'. Did you mean gamma?"),
        (("gamma=1,-1",), "gamma=-1: gamma must be > 0"),
        (("gamma=1,",), "gamma has an empty value"),
        (("gamma=1", "gamma=2"), "gamma is given twice"),
        (("delta=3,3",), "has a value twice"),
        (("delta=1.5",), "must be a whole number"),
        (("seed=3:3",), "has no values"),
        (("robot=r2d2",), "robot=r2d2"),
    ],
)
def test_an_axis_that_makes_no_sense_is_refused(axes, message):
    with pytest.raises(InputError, match=message.replace("?", r"\?")):
        parse(axes, 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("gamma=1 --engine ray", "needs --address"),
        ("gamma=1 --address 1.2.3.4:5", "engine ray"),
        ("gamma=1 --workers 0", "workers must be >= 1"),
        ("gamma=1 --into file", "file is a file"),
        ("gamma=1 --engine cloud", "engine"),
    ],
)
def test_bad_input_is_one_line(armside, tmp_path, options, message):
    (tmp_path / "file").touch()
    status, out, err = armside(f"sweep {options}")
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The dataset of AXES, computed in this process without any disturbance."""
    folder = tmp_path_factory.mktemp("whole")
    counts = run_grid(parse(AXES, 0), Store(folder), Serial())
    assert counts == {"done": 4, "failed": 4}
    return read(folder)


def test_rows_are_what_armside_laser_finds(whole):
    (row,) = [
        row
        for row in whole.to_pylist()
        if (row["gamma"], row["pose"], row["seed"]) == ([0.9], "p1", 1)
    ]
    found = run(LaserCfg(speed=60.0, iterations=1), 1)
    assert row["arm_rms"] == [it["arm_rms"] for it in found["iterations"]]
    assert row["motor_two"] == [it["motor_two"].tolist() for it in found["iterations"]]
    assert (row["status"], row["error"]) == ("done", None)


def test_a_configuration_that_fails_is_recorded_with_its_error(whole):
    rows = [row for row in whole.to_pylist() if row["pose"] == "p9"]
    assert len(rows) == 4
    for row in rows:
        assert row["status"] == "failed"
        assert "Unknown pose 'p9'" in row["error"]
        assert row["arm_rms"] is None


def test_what_is_there_is_not_computed_again(tmp_path):
    few, many = parse(("delta=1:4",), 0), parse(("delta=1:9",), 0)
    assert run_grid(few, Store(tmp_path), Serial(quick)) == {"done": 3}
    engine = Serial(quick)
    assert run_grid(many, Store(tmp_path), engine) == {"known": 3, "done": 5}
    assert len(engine.ran) == 5
    keys = read(tmp_path)["key"].to_pylist()
    assert keys == sorted(point.key for point in many)


def test_failed_configurations_run_again_only_when_asked(tmp_path):
    grid = parse(("delta=1:4",), 0)
    broken = Serial(lambda point: failed(point, "no luck"))
    assert run_grid(grid, Store(tmp_path), broken) == {"failed": 3}
    assert run_grid(grid, Store(tmp_path), Serial(quick)) == {"known": 3}
    assert run_grid(grid, Store(tmp_path), Serial(quick), retry_failed=True) == {"done": 3}
    assert read(tmp_path)["status"].to_pylist() == ["done"] * 3


def test_a_result_is_safe_once_it_was_added_and_a_torn_one_is_cut_off(tmp_path):
    point = next(iter(parse(("delta=1",), 0)))
    name = block_of(point.key)
    block = Store(tmp_path).claim(name)
    block.add(quick(point))
    assert block._open is not None
    block._open.close()  # its process died here:
    os.close(block._lock)  # the kernel closed its files
    journal = tmp_path / ".journal" / f"{name}.jsonl"
    with open(journal, "ab") as file:
        file.write(b'{"key": "half a li')
    assert rows_kept(tmp_path) == 1
    again = Store(tmp_path).claim(name)
    assert again.done == {point.key}
    again.close()
    assert read(tmp_path)["key"].to_pylist() == [point.key]
    assert not journal.exists()


def test_a_writer_that_died_between_part_and_journal_leaves_no_row_twice(tmp_path):
    point = next(iter(parse(("delta=1",), 0)))
    run_grid(parse(("delta=1",), 0), Store(tmp_path), Serial(quick))
    name = block_of(point.key)
    line = json.dumps(quick(point)) + "\n"
    (tmp_path / ".journal" / f"{name}.jsonl").write_text(line)
    (tmp_path / f".part-{name}.parquet.123.partial").write_bytes(b"PAR1")
    Store(tmp_path).claim(name).close()
    assert len(read(tmp_path)) == 1
    assert not list(tmp_path.glob(".part*"))


def test_a_block_has_one_writer_at_a_time(tmp_path):
    first = Store(tmp_path).claim("ab")
    assert Store(tmp_path).claim("ab") is None
    first.close()
    Store(tmp_path).claim("ab").close()


def _start(folder):
    command = [sys.executable, "-m", "scripts.cli", "sweep", *AXES, "--quiet"]
    return subprocess.Popen([*command, "--into", str(folder)], cwd=ROOT, start_new_session=True)


def test_killed_at_random_it_loses_nothing_and_leaves_no_process_behind(tmp_path, whole):
    process = _start(tmp_path)
    deadline = time.monotonic() + 60
    while rows_kept(tmp_path) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(random.Random(0).uniform(0, 0.1))
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = rows_kept(tmp_path)
    assert kept >= 2
    counts = run_grid(parse(AXES, 0), Store(tmp_path), Serial())
    assert counts["known"] == kept
    assert counts.total() == 8
    assert read(tmp_path).equals(whole)
    deadline = time.monotonic() + 20
    while _members(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not _members(process.pid)


def _members(session):
    """Processes of a session that are not over."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def test_two_sweeps_into_one_folder_share_the_work(tmp_path, whole):
    both = [_start(tmp_path) for _ in range(2)]
    assert [process.wait(120) for process in both] == [0, 0]
    assert read(tmp_path).equals(whole)


def test_part_files_can_be_read_while_a_sweep_runs(tmp_path):
    seen = []

    def look(point):
        seen.append(len(read(tmp_path)))
        return quick(point)

    run_grid(parse(("delta=1:13",), 0), Store(tmp_path), Serial(look))
    assert seen == sorted(seen)
    assert 0 < seen[-1] < 13
    for part in tmp_path.glob("part-*.parquet"):
        assert pq.read_schema(part).equals(schema())


def test_a_worker_that_dies_takes_only_its_own_point_with_it(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parent)
    probe = importlib.import_module("sweep_probe")
    grid = Grid({"speed": (60.0,), "seed": range(5)})
    counts = run_grid(grid, Store(tmp_path), Local(2, function=probe.dies_with_seed_1))
    assert counts == {"done": 4, "failed": 1}
    (row,) = [r for r in read(tmp_path).to_pylist() if r["status"] == "failed"]
    assert (row["seed"], row["error"]) == (1, "the worker process died")


def test_results_are_not_kept_in_memory(tmp_path):
    def peak(n):
        grid = Grid({"speed": (60.0,), "seed": range(n)})
        large = Serial(lambda point: quick(point) | {"arm_rms": [0.5] * 2000})
        tracemalloc.start()
        run_grid(grid, Store(tmp_path / str(n)), large)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    few, many = peak(20), peak(120)
    assert many < few + 100 * 2000 * 8 / 4  # a quarter of what the results alone would take


def test_a_point_survives_the_way_to_a_worker():
    import pickle

    point = Point(key="0" * 16, options={"gamma": (0.9,)}, seed=3)
    assert pickle.loads(pickle.dumps(point)) == point
