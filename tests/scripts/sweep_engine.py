"""Grids of a sweep, and an engine that runs them in this process or in another."""

import subprocess
import sys
import time
from pathlib import Path

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Point

PLACES = "position=1316.6/1.4/1599.2,9000/0/1000"
AXES = ("gamma=0.5,0.9", PLACES, "speed=60", "iterations=1", "seed=0:2")
"""Half of them can be done, at p1: the second place is out of reach."""
ROOT = Path(__file__).parent.parent.parent


class Serial:
    """An engine that runs a point when its result is asked for, by a function in place of its own
    `run` if one is given."""

    def __init__(self, function=Point.run):
        self.function, self.ran = function, []

    def results(self, _run, items):
        for key, point in items:
            self.ran.append(key)
            yield (key, point), self.function(point)

    def close(self):
        pass


def failed(point, error):
    """The row of a point that has failed with that message."""
    return point.failed(RuntimeError(error)) | {"error": error}


def quick(point):
    """A row without an experiment."""
    return failed(point, "") | {"status": "done", "error": None}


def failing_with(*errors):
    """A function that runs points: those with delta 2 and more fail."""

    def unlucky(point):
        (delta,) = point.options["delta"]
        return quick(point) if delta == 1 else failed(point, errors[delta - 2])

    return unlucky


def start(folder, **options):
    """A process of its own that sweeps AXES."""
    command = [sys.executable, "-m", "armside.scripts.cli", "sweep", *AXES, "--quiet"]
    return subprocess.Popen(
        [*command, "--into", str(folder)], cwd=ROOT, start_new_session=True, **options
    )


def wait_for(folder, n):
    """Wait until a dataset has so many rows."""
    deadline = time.monotonic() + 60
    while len(Dataset(folder).keys()) < n and time.monotonic() < deadline:
        time.sleep(0.02)
