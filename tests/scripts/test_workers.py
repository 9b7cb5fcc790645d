"""Worker processes: order, exceptions, and a process that dies."""

import math
import os

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


def test_a_number_of_processes_is_at_least_one():
    with pytest.raises(ValueError, match="workers must be >= 1, got 0"):
        Workers(0)
