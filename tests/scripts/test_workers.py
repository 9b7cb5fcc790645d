"""Worker processes: order, exceptions, and a process that dies."""

import importlib
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from armside.scripts.jobs.workers import WorkerDied, Workers

HERE = Path(__file__).parent


@pytest.fixture
def ends(monkeypatch):
    """A function that takes its process along for a negative number."""
    monkeypatch.syspath_prepend(HERE)
    return importlib.import_module("sweep_probe").root_or_end


def test_results_come_in_the_order_of_the_items():
    with Workers(2) as workers:
        assert workers.map(math.sqrt, [9.0, 4.0, 1.0]) == [3.0, 2.0, 1.0]
        assert workers.map(math.sqrt, [16.0]) == [4.0]


def test_an_exception_is_raised_where_the_results_are_asked_for():
    with Workers(2) as workers, pytest.raises(ValueError, match=r"math domain|nonnegative"):
        workers.map(math.sqrt, [1.0, -1.0, 4.0])


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
        with pytest.raises(WorkerDied, match="killed"):
            workers.map(os._exit, [1])
        assert workers.map(math.sqrt, [4.0]) == [2.0]


def test_an_interruption_does_not_wait_for_tasks_in_flight():
    def interrupted():
        with Workers(1) as workers:
            for _ in workers.results(time.sleep, [0.0, 600.0]):
                raise KeyboardInterrupt

    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - begin < 300.0


def test_a_number_of_processes_is_at_least_one():
    with pytest.raises(ValueError, match="workers must be >= 1, got 0"):
        Workers(0)


WAITING = """
import time
from armside.scripts.jobs.workers import Workers
from armside.scripts.shell.interrupts import SIGNALS
SIGNALS.handle()
try:
    with Workers(2) as workers:
        workers.map(len, ["started"])
        print("started", flush=True)
        workers.map(time.sleep, [100.0, 100.0])
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
