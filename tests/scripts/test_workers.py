"""Worker processes: order, exceptions, and a process that dies."""

import math
import os
import signal
import subprocess
import sys
import time

import pytest

from armside.scripts.jobs.workers import WorkerDied, Workers


def test_results_come_in_the_order_of_the_items():
    with Workers(2) as workers:
        assert workers.map(math.sqrt, [9.0, 4.0, 1.0]) == [3.0, 2.0, 1.0]
        assert workers.map(math.sqrt, [16.0]) == [4.0]


def test_an_exception_is_raised_where_the_results_are_asked_for():
    with Workers(2) as workers, pytest.raises(ValueError, match=r"math domain|nonnegative"):
        workers.map(math.sqrt, [1.0, -1.0, 4.0])


def test_a_process_that_dies_is_named_and_the_others_have_results():
    with Workers(2) as workers:
        workers.submit("dies", os._exit, 1)
        workers.submit("lives", math.sqrt, 4.0)
        outcomes = {}
        while workers.busy:
            outcomes |= dict(workers.collect())
        assert outcomes["lives"] == 2.0
        assert isinstance(outcomes["dies"], WorkerDied)
        with pytest.raises(WorkerDied, match="killed"):
            workers.map(os._exit, [1])
        assert workers.map(math.sqrt, [4.0]) == [2.0]


def test_an_interruption_does_not_wait_for_tasks_in_flight():
    def interrupted():
        with Workers(1) as workers:
            workers.submit("long", time.sleep, 600.0)
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
