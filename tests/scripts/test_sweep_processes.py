"""Processes of a sweep: interrupted, killed, and several in one folder."""

import importlib
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Grid, Point, parse, run_grid
from armside.scripts.jobs.workers import Workers

from .sweep_engine import AXES, Serial, start, wait_for


def test_ctrl_c_in_a_terminal_is_one_line(tmp_path):
    process = start(tmp_path, stderr=subprocess.PIPE)
    wait_for(tmp_path, 3)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=60)
    kept = len(Dataset(tmp_path).keys())
    assert (process.returncode, err.count(b"\n")) == (130, 1)
    assert f"{kept} of 8 configurations are kept".encode() in err


@pytest.fixture
def probe(monkeypatch):
    """Module of jobs that run no experiment."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("sweep_probe")


def test_a_sweep_claims_no_more_than_it_works_on(tmp_path, probe):
    grid = [probe.Quick(point) for point in parse(("delta=1:21",), 0)]
    held = []

    def look():
        held.append(len(list((tmp_path / ".claims").iterdir())))

    with Workers(2) as workers:
        run_grid(grid, Dataset(tmp_path), workers, look)
    assert max(held) <= 2


def test_killed_at_random_it_loses_nothing_and_leaves_no_process_behind(tmp_path, whole):
    process = start(tmp_path)
    wait_for(tmp_path, 2)
    time.sleep(random.Random(0).uniform(0, 0.1))
    process.send_signal(signal.SIGKILL)
    process.wait()
    kept = len(Dataset(tmp_path).keys())
    assert kept >= 2
    counts = run_grid(parse(AXES, 0), Dataset(tmp_path), Serial())
    assert counts["known"] + counts["known (failed)"] == kept
    assert counts.total() == 8
    assert Dataset(tmp_path).read().equals(whole)
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


def test_a_worker_that_dies_takes_only_its_own_point_with_it(tmp_path, probe):
    grid = [probe.DiesWithSeed1(point) for point in Grid({"speed": (60.0,), "seed": range(5)})]
    with Workers(2) as workers:
        counts = run_grid(grid, Dataset(tmp_path), workers)
    assert counts == {"done": 4, "failed": 1}
    (row,) = [r for r in Dataset(tmp_path).read().to_pylist() if r["status"] == "failed"]
    assert (row["seed"], row["error"]) == (1, "a worker process was killed (out of memory?)")


def test_a_point_survives_the_way_to_a_worker():
    import pickle

    point = Point(key="0" * 16, options={"gamma": (0.9,)}, seed=3)
    assert pickle.loads(pickle.dumps(point)) == point
