"""Repeated runs of the virtual robot along a path of waypoints."""

from collections.abc import Callable

import numpy as np

from armside.arrays import Array

from ..cell import CELLS
from ..measured.motion import Stream
from ..motion.timing import PathLimits, rest_to_rest
from ..robot.cell_model import cell_model
from ..robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .waypoint_path import WaypointPath

REST = 0.5
"""[s] At both ends."""


def virtual_runs(
    path: WaypointPath, speed: float, n: int, seed: int, step: Callable[[], None] = lambda: None
) -> list[Stream]:
    """Motor logs of n runs of the virtual large robot, by its encoders at 250 Hz.

    speed: [m/s]. Runs have noise of their own.

    Raises:
        RuntimeError: a run has become unstable.
    """
    cell = CELLS["large"]
    loaded = VirtualRobot(cell_model(cell, cell.xml)).load(_reference(path, speed))
    runs: list[Stream] = []
    for child in np.random.SeedSequence(seed).spawn(n):
        recording = loaded.run(rng=np.random.default_rng(child))
        if not np.isfinite(recording.motor_angle).all():
            raise RuntimeError(f"the virtual robot is unstable at {1e3 * speed:g} mm/s")
        runs.append(Stream(recording.time, recording.motor_angle))
        step()
    return runs


def _reference(path: WaypointPath, speed: float) -> Array:
    timing = rest_to_rest(path.length, speed, PathLimits())
    time = np.arange(-REST, timing.duration + REST, LOG_PERIOD)
    return path.motor_angles(timing.at(time)[0])
