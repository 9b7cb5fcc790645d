"""`armside sweep`: what is asked for is there once, whatever happened on the way."""

import errno
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

from armside import assets
from armside.scripts.cutting.learning import run
from armside.scripts.cutting.options import LaserCfg
from armside.scripts.jobs import resolved
from armside.scripts.jobs.dataset import dataset, schema
from armside.scripts.jobs.grid import Grid, parse
from armside.scripts.jobs.point import Point, run_grid
from armside.scripts.jobs.resolved import key_of
from armside.scripts.jobs.workers import Workers
from armside.scripts.shell.errors import InputError

PLACES = "position=1316.6/1.4/1599.2,9000/0/1000"
AXES = ("gamma=0.5,0.9", PLACES, "speed=60", "iterations=1", "seed=0:2")
"""Half of them can be done, at p1: the second place is out of reach."""
ROOT = Path(__file__).parent.parent.parent


class Serial:
    """An engine that runs a point when it is asked for results, by a function in place of its own
    `run` if one is given."""

    def __init__(self, function=Point.run):
        self.function, self.queue, self.ran = function, [], []

    @property
    def room(self):
        return 2 - len(self.queue)

    @property
    def busy(self):
        return bool(self.queue)

    def submit(self, key, _run, point):
        self.queue.append((key, point))

    def collect(self):
        key, point = self.queue.pop(0)
        self.ran.append(key)
        return [(key, self.function(point))]

    def close(self):
        self.queue.clear()


def failed(point, error):
    """The row of a point that has failed with that message."""
    return point.failed(RuntimeError(error)) | {"error": error}


def quick(point):
    """A row without an experiment."""
    return failed(point, "") | {"status": "done", "error": None}


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


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({}, {"law": "heuristic", "payload": 40.0}),
        ({}, {"gamma": (0.9,) * 6, "delta": (3,) * 6}),
        ({}, {"stiffness_error": 10.0, "on_imu_fault": "go-on"}),
        ({}, {"position": (1316.6, 1.4, 1599.2), "pose": "p2"}),
        ({"measure": "estimate"}, {"measure": "estimate", "law": "inverse", "cutoff": (10.0,)}),
        ({"robot": "irb1400"}, {"robot": "irb1400", "cutoff": (20.0,)}),
        ({"shape": "square"}, {"shape": "square", "size": 20.0, "corner": 3.0}),
        ({"shape": "slot", "size": 24.0}, {"shape": "slot", "size": 24.0, "width": 8.0}),
    ],
)
def test_options_that_come_to_the_same_run_have_the_same_key(one, other):
    assert key_of(one, 0) == key_of(other, 0)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        # The default cutoff is 12.7 Hz there.
        ({"measure": "estimate", "speed": 100.0}, {"cutoff": (10.0,)}),
        ({"measure": "estimate"}, {"stiffness_error": 10.0}),
        ({}, {"position": (1316.6, 1.4, 1599.3)}),
        ({}, {"payload": 41.0}),
        ({}, {"measure": "tracker"}),
        ({"robot": "irb1400"}, {"cutoff": (10.0,)}),
    ],
)
def test_options_that_come_to_different_runs_have_different_keys(one, other):
    assert key_of(one, 0) != key_of(one | other, 0)


def test_a_point_is_there_once_however_often_its_grid_says_it():
    grid = parse(("law=auto,heuristic", "gamma=0.9,0.9/0.9/0.9/0.9/0.9/0.9", "seed=0:2"), 0)
    assert len(grid) == 8
    assert [point.seed for point in grid] == [0, 1]


def test_a_row_has_the_options_that_were_run():
    (fast,) = parse(("measure=estimate", "speed=100"), 0)
    row = failed(fast, "not run")
    assert row["cutoff"] == pytest.approx([400.0 / (10.0 * 3.141592653589793)])
    assert (row["law"], row["gamma"], row["payload"]) == ("inverse", [0.9], 40.0)
    assert (row["pose"], row["position"]) == ("p1", [1316.6, 1.4, 1599.2])
    (square,) = parse(("shape=square", "position=1500/0/1599.2"), 0)
    row = failed(square, "not run")
    assert (row["size"], row["corner"], row["radius"]) == (20.0, 3.0, None)
    assert (row["pose"], row["law"]) == (None, "heuristic")


CONTOUR = "points = [[-10, -6], [10, -6], [10, {top}], [-10, 6]]\n"
SCENE = '<mujoco><include file="{robot}"/></mujoco>'


def _write_contour(folder, changed):
    file = folder / "part.toml"
    file.write_text(CONTOUR.format(top=7 if changed else 6))
    return {"contour": file}


def _write_model(folder, changed):
    robot = Path(assets.LARGE_ROBOT_XML).read_text()
    (folder / "robot.xml").write_text(robot + "<!-- -->" if changed else robot)
    (folder / "scene.xml").write_text(SCENE.format(robot="robot.xml"))
    return {"model": folder / "scene.xml"}


def _write_identification(folder, changed):
    (folder / "summary.json").write_text(json.dumps({"springs": changed}))
    return {"identification": folder, "measure": "estimate"}


@pytest.mark.parametrize("write", [_write_contour, _write_model, _write_identification])
def test_a_file_with_another_content_is_another_configuration_wherever_it_is(tmp_path, write):
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    key = key_of(write(here, False), 0)
    assert key_of(write(there, False), 0) == key
    assert key_of(write(here, True), 0) != key


def test_a_file_that_changes_while_a_sweep_runs_leaves_no_result_under_the_old_key(tmp_path):
    cut = _write_contour(tmp_path, changed=False) | {"iterations": 0}
    (point,) = Grid({name: (value,) for name, value in cut.items()} | {"seed": (0,)})
    assert point.run()["status"] == "done"
    _write_contour(tmp_path, changed=True)
    row = point.run()
    assert (row["status"], "not what it was" in row["error"]) == ("failed", True)


def test_a_value_is_checked_beside_those_of_the_other_axes():
    (point,) = parse(("law=norm-optimal", "measure=estimate"), 0)
    assert point.options == {"law": "norm-optimal", "measure": "estimate"}
    assert len(list(parse(("law=auto,inverse", "measure=motor,estimate"), 0))) == 3


def test_only_options_of_several_values_are_split_and_may_be_empty(tmp_path):
    file = _write_contour(tmp_path, changed=False)["contour"]
    (point,) = parse((f"contour={file}",), 0)
    assert point.options == {"contour": file}
    none, two = parse(("without=,ripple/gear-error",), 0)
    assert none.options == {"without": ()}
    assert two.options == {"without": ("ripple", "gear-error")}


def test_a_relative_path_is_the_same_file_for_workers_elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(_write_contour(tmp_path, changed=False)["contour"].parent)
    (point,) = parse(("contour=part.toml",), 0)
    assert point.options == {"contour": tmp_path / "part.toml"}


def _counted(monkeypatch, name):
    """Calls of a function of `resolved` from now on."""
    calls, function = [], getattr(resolved, name)

    def noted(*args, **options):
        calls.append(args)
        return function(*args, **options)

    monkeypatch.setattr(resolved, name, noted)
    return calls


def test_each_configuration_of_a_grid_is_resolved_once_whatever_its_seeds(monkeypatch):
    calls = _counted(monkeypatch, "LaserCfg")
    points = list(parse(("gamma=0.1,0.2,0.3,0.4", "seed=0:50"), 0))
    assert len(points) == 200
    assert len(calls) == 4


def test_each_file_of_a_grid_is_hashed_once(monkeypatch, tmp_path):
    calls = _counted(monkeypatch, "content_of")
    files = []
    for name in "ab":
        (tmp_path / name).mkdir()
        files.append(_write_contour(tmp_path / name, changed=name == "b")["contour"])
    points = list(parse((f"contour={files[0]},{files[1]}", "gamma=0.1,0.2,0.3", "seed=0:9"), 0))
    assert len(points) == 54
    assert sorted(calls) == [("contour", file) for file in files]


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
        (("gamma=1,",), "gamma=: gamma takes one value or six, got 0"),
        (("speed=40,",), "speed has an empty value"),
        (("contour=",), "contour has an empty value"),
        (("pose=p1,p9",), "pose=p9: Unknown pose 'p9'"),
        (("shape=circle,square", "radius=8"), "shape=square: a square has no radius"),
        (("gamma=1,2", "shape=square", "radius=8"), "no configuration of the grid can be run"),
        (("law=inverse", "gamma=1,2"), "law=inverse: law inverse needs --measure"),
        (("law=inverse", "measure=estimate", "cutoff=-1"), "cutoff=-1: cutoff must be above 0"),
        (("position=1/2",), "position=1/2: Incorrect number"),
        (("contour=a/missing.toml",), "missing.toml: .* No such file"),
        (("seed=-1,0",), "seed=-1: seed must be >= 0"),
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
        ("pose=p1,p9", "Unknown pose 'p9'"),
    ],
)
def test_bad_input_is_one_line(armside, tmp_path, options, message):
    (tmp_path / "file").touch()
    status, out, err = armside(f"sweep {options}")
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_the_engine_is_asked_before_the_grid_is_built(armside, monkeypatch):
    monkeypatch.setattr(
        "armside.scripts.commands.sweep.parse", lambda *_: pytest.fail("built a grid")
    )
    status, _, err = armside("sweep gamma=1 --engine ray --address 127.0.0.1:1")
    assert (status, "Ray" in err) == (2, True)


def test_without_ray_the_extra_is_named(armside, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    status, _, err = armside("sweep gamma=1 --engine ray --address 127.0.0.1:1")
    assert status == 2
    assert err == "armside: the engine ray needs Ray: pip install 'armside[cluster]'\n"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The dataset of AXES, computed in this process without any disturbance."""
    folder = tmp_path_factory.mktemp("whole")
    counts = run_grid(parse(AXES, 0), dataset(folder), Serial())
    assert counts == {"done": 4, "failed": 4}
    return dataset(folder).read()


def test_rows_are_what_armside_laser_finds(whole):
    (row,) = [
        row
        for row in whole.to_pylist()
        if (row["gamma"], row["pose"], row["seed"]) == ([0.9], "p1", 1)
    ]
    place = (1316.6, 1.4, 1599.2)
    found = run(LaserCfg(speed=60.0, iterations=1, position=place), 1)
    assert row["arm_rms"] == [it["arm_rms"] for it in found["iterations"]]
    assert row["motor_two"] == [it["motor_two"].tolist() for it in found["iterations"]]
    assert row["notes"] == [note.line for note in found["notes"]]
    assert (row["status"], row["error"]) == ("done", None)


def test_a_configuration_that_fails_is_recorded_with_its_error(whole):
    rows = [row for row in whole.to_pylist() if row["position"][0] == 9000.0]
    assert len(rows) == 4
    for row in rows:
        assert row["status"] == "failed"
        assert "out of reach" in row["error"]
        assert row["arm_rms"] is None


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
    point = next(iter(parse(("delta=1",), 0)))
    name = dataset(tmp_path).name(point.key)
    block = dataset(tmp_path).claim(name)
    block.add(quick(point))
    assert block._open is not None
    block._open.close()  # its process died here:
    os.close(block._lock)  # the kernel closed its files
    journal = tmp_path / ".journal" / f"{name}.jsonl"
    with open(journal, "ab") as file:
        file.write(b'{"key": "half a li')
    assert dataset(tmp_path).keys() == {point.key}
    again = dataset(tmp_path).claim(name)
    assert again.done == {point.key}
    again.close()
    assert dataset(tmp_path).read()["key"].to_pylist() == [point.key]
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


def test_failed_configurations_end_in_status_1_with_the_first_error(armside, monkeypatch):
    unlucky = failing_with("no luck with 2", "no luck with 3")
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(unlucky))
    status, out, err = armside("sweep delta=1:4 --into there --json")
    assert (status, err.count("\n")) == (1, 1)
    assert "2 of 3 configurations failed, the first with no luck with 2" in err
    assert "--retry-failed" in err
    assert json.loads(out)["status"] == "failed"
    status, out, err = armside("sweep delta=1:4 --into there")
    assert (status, "no luck with 2" in err) == (1, True)
    assert "3 configurations: 1 known, 2 known (failed)" in out
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(quick))
    status, out, err = armside("sweep delta=1:4 --into there --retry-failed")
    assert (status, err) == (0, "")
    assert "2 done, 1 known" in out


def noted(point):
    (delta,) = point.options["delta"]
    return quick(point) | {"notes": ["the speed is lowered"] if delta > 1 else []}


def test_limits_are_counted_at_the_end_and_noted_in_the_rows(armside, tmp_path, monkeypatch):
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(noted))
    _, out, _ = armside("sweep delta=1:4 --into there")
    said = "Note: limits changed 2 of them (column notes), mostly: the speed is lowered\n"
    assert said in out
    _, out, _ = armside("sweep delta=1:4 --into there --json")
    assert json.loads(out)["notes"] == [{"text": "the speed is lowered", "configurations": 2}]
    assert sorted(map(len, dataset(tmp_path / "there").read()["notes"].to_pylist())) == [0, 1, 1]
    _, out, _ = armside("sweep delta=1 --into there")
    assert "Note" not in out


def test_a_dataset_of_before_notes_is_read_and_added_to(armside, tmp_path, monkeypatch):
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(noted))
    assert armside("sweep delta=1:4 --into there").status == 0
    for part in (tmp_path / "there").glob("part-*"):
        pq.write_table(pq.read_table(part).drop_columns(["notes"]), part)
    status, out, _ = armside("sweep delta=1:5 --into there")
    assert (status, "1 done, 3 known" in out) == (0, True)
    assert "limits changed 1 of them" in out


def failing_with(*errors):
    """A function that runs points: those with delta 2 and more fail."""

    def unlucky(point):
        (delta,) = point.options["delta"]
        return quick(point) if delta == 1 else failed(point, errors[delta - 2])

    return unlucky


def test_ctrl_c_says_what_is_kept(armside, tmp_path, monkeypatch):
    def stop_at_3(point):
        if point.options["delta"] == (3,):
            raise KeyboardInterrupt
        return quick(point)

    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(stop_at_3))
    status, _, err = armside("sweep delta=3 --into there")
    assert (status, err) == (130, "armside: interrupted, nothing was kept\n")
    status, _, err = armside("sweep delta=1:9 --into there")
    kept = len(dataset(tmp_path / "there").read())
    assert 0 < kept < 8
    assert status == 130
    assert f"{kept} of 8 configurations are kept in there, repeat the command to go on" in err


def test_ctrl_c_in_a_terminal_is_one_line(tmp_path):
    process = _start(tmp_path, stderr=subprocess.PIPE)
    _wait_for(tmp_path, 3)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=60)
    kept = len(dataset(tmp_path).keys())
    assert (process.returncode, err.count(b"\n")) == (130, 1)
    assert f"{kept} of 8 configurations are kept".encode() in err


@pytest.fixture
def probe(monkeypatch):
    """Module of jobs that run no experiment."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("sweep_probe")


def test_a_sweep_claims_no_more_than_it_works_on(tmp_path, probe):
    grid = [probe.Quick(point) for point in parse(("delta=1:21",), 0)]
    names = {dataset(tmp_path).name(point.key) for point in grid}
    held = []

    def look():
        claimed = [dataset(tmp_path).claim(name) for name in names]
        held.append(claimed.count(None))
        for block in filter(None, claimed):
            block.close()

    with Workers(2) as workers:
        run_grid(grid, dataset(tmp_path), workers, look)
    assert max(held) <= 2


def test_who_can_only_wait_for_others_says_so_once(tmp_path, armside, monkeypatch):
    monkeypatch.setattr("armside.scripts.jobs.queue.POLL", 0.01)
    grid = list(parse(("delta=1:4",), 0))
    store = dataset(tmp_path / "there")
    theirs = store.claim(dataset(tmp_path).name(grid[0].key))
    n_theirs = sum(dataset(tmp_path).name(point.key) == theirs.name for point in grid)
    monkeypatch.setattr("armside.scripts.commands.sweep.Workers", lambda _: Serial(quick))
    looks = []

    def sleep(_):
        looks.append(None)
        if len(looks) == 3:
            theirs.close()

    monkeypatch.setattr("armside.scripts.jobs.queue.time.sleep", sleep)
    status, _, err = armside("sweep delta=1:4 --into there")
    said = f"armside: waiting for {n_theirs} configurations that another sweep has claimed\n"
    assert (status, err, len(looks)) == (0, said, 3)


def _start(folder, **options):
    command = [sys.executable, "-m", "armside.scripts.cli", "sweep", *AXES, "--quiet"]
    return subprocess.Popen(
        [*command, "--into", str(folder)], cwd=ROOT, start_new_session=True, **options
    )


def _wait_for(folder, n):
    deadline = time.monotonic() + 60
    while len(dataset(folder).keys()) < n and time.monotonic() < deadline:
        time.sleep(0.02)


def test_killed_at_random_it_loses_nothing_and_leaves_no_process_behind(tmp_path, whole):
    process = _start(tmp_path)
    _wait_for(tmp_path, 2)
    time.sleep(random.Random(0).uniform(0, 0.1))
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = len(dataset(tmp_path).keys())
    assert kept >= 2
    counts = run_grid(parse(AXES, 0), dataset(tmp_path), Serial())
    assert counts["known"] + counts["known (failed)"] == kept
    assert counts.total() == 8
    assert dataset(tmp_path).read().equals(whole)
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
    assert [process.wait(120) for process in both] == [1, 1]  # half of it cannot be done
    assert dataset(tmp_path).read().equals(whole)


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


def test_a_worker_that_dies_takes_only_its_own_point_with_it(tmp_path, probe):
    grid = [probe.DiesWithSeed1(point) for point in Grid({"speed": (60.0,), "seed": range(5)})]
    with Workers(2) as workers:
        counts = run_grid(grid, dataset(tmp_path), workers)
    assert counts == {"done": 4, "failed": 1}
    (row,) = [r for r in dataset(tmp_path).read().to_pylist() if r["status"] == "failed"]
    assert (row["seed"], row["error"]) == (1, "a worker process was killed (out of memory?)")


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


def test_a_point_survives_the_way_to_a_worker():
    import pickle

    point = Point(key="0" * 16, options={"gamma": (0.9,)}, seed=3)
    assert pickle.loads(pickle.dumps(point)) == point
