"""Worker processes: order, exceptions, and a process that dies."""

import importlib
import math
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Grid, parse, run_grid
from armside.scripts.jobs.workers import WorkerDied, Workers
from armside.scripts.shell.errors import RunFailed

from .sweep_engine import AXES, Serial, quick, start, wait_for


def test_ctrl_c_in_a_terminal_is_one_line(tmp_path):
    process = start(tmp_path, stderr=subprocess.PIPE)
    wait_for(tmp_path, 3)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=60)
    kept = len(Dataset(tmp_path).keys())
    assert (process.returncode, err.count(b"\n")) == (130, 1)
    assert f"{kept} of 8 configurations are kept".encode() in err


class TwoWordsError(ValueError):
    """Cannot be sent: pickle calls it with its message alone."""

    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")


def _two_words(_):
    raise TwoWordsError("this", "that")


def test_an_exception_that_cannot_be_sent_is_no_death_of_a_worker():
    with Workers(1) as workers:
        ((_, found),) = workers.results(_two_words, [0])
    assert (type(found), str(found)) == (RunFailed, "TwoWordsError: this and that")


def test_a_sweep_claims_no_more_than_it_works_on(tmp_path):
    held = []

    def look(point):
        held.append(len(list((tmp_path / ".claims").iterdir())))
        return quick(point)

    run_grid(parse(("delta=1:21",), 0), Dataset(tmp_path), Serial(look))
    assert held == [1] * 20


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


def test_a_worker_that_dies_takes_only_its_own_point_with_it(tmp_path):
    def dies_with_seed_1(point):
        return WorkerDied() if point.seed == 1 else quick(point)

    grid = Grid({"speed": (60.0,), "seed": range(5)})
    counts = run_grid(grid, Dataset(tmp_path), Serial(dies_with_seed_1))
    assert counts == {"done": 4, "failed": 1}
    (row,) = [r for r in Dataset(tmp_path).read().to_pylist() if r["status"] == "failed"]
    assert (row["seed"], row["error"]) == (1, "a worker process was killed (out of memory?)")


@pytest.fixture
def ends(monkeypatch):
    """Square root, which takes its process along for a negative number."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("sweep_probe").root_or_end


def test_items_are_taken_when_they_can_start():
    taken = []

    def items():
        for i in range(6):
            taken.append(i)
            yield float(i)

    with Workers(2) as workers:
        for n, _ in enumerate(workers.results(math.sqrt, items()), 1):
            assert len(taken) <= n + 2


def test_a_process_that_dies_is_named_and_the_others_have_results(ends):
    with Workers(2) as workers:
        outcomes = dict(workers.results(ends, [4.0, -1.0, 9.0]))
        assert (outcomes[4.0], outcomes[9.0]) == (2.0, 3.0)
        assert isinstance(outcomes[-1.0], WorkerDied)
        outcomes = dict(workers.results(math.sqrt, [4.0, -1.0]))
        assert outcomes[4.0] == 2.0
        assert isinstance(outcomes[-1.0], ValueError)


def test_an_interruption_does_not_wait_for_tasks_in_flight():
    def interrupted():
        with Workers(1) as workers:
            for _ in workers.results(time.sleep, [0.0, 600.0]):
                raise KeyboardInterrupt

    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - begin < 300.0


WAITING = """
import time
from armside.scripts.jobs.workers import Workers
from armside.scripts.shell.interrupts import SIGNALS
SIGNALS.handle()
try:
    with Workers(2) as workers:
        list(workers.results(len, ["started"]))
        print("started", flush=True)
        list(workers.results(time.sleep, [100.0, 100.0]))
finally:
    SIGNALS.ignore()
"""


def test_a_second_signal_does_not_wait_for_the_tasks_in_flight():
    command = [sys.executable, "-c", WAITING]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"started\n"
        time.sleep(1.0)
        for _ in range(2):
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        try:
            process.wait(30.0)
        finally:
            process.kill()


def test_a_number_of_processes_is_at_least_one():
    with pytest.raises(ValueError, match="workers must be >= 1, got 0"):
        Workers(0)
