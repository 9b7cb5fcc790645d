"""Real motor logs of a path beside runs of the virtual robot along it, by speed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from armside.arrays import Array
from armside.kinematics import Arm, compile

from ...cell import CELLS
from ...motion.timing import PathLimits, rest_to_rest
from ...robot.kinematics_check import cell_model
from ...robot.virtual_robot import LOG_PERIOD, VirtualRobot
from ..recorded_motion import Stream
from .waypoint_path import PathLogs, PathScatter, WaypointPath, path_scatter, waypoint_path

HALF = 10
"""Samples on either side that the cubic spans."""
SLOWEST = 0.02
"""[rad/s] Rate below which a motor tells nothing of time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TimingErrors:
    """Errors of the sampling instants of each motor, taken from logs.

    A motor that moves at rate w and is read d later than its stamp says is off by w d. They are
    found where a log departs from a cubic over its neighbours, motor by motor, and applied to any
    smooth motion: what such a log makes of a robot that repeats perfectly.
    """

    errors: tuple[Array, ...]
    """Of each log (N, n) [s], in the order of its samples."""
    period: float
    """[s], median step of the stamps."""

    @property
    def deviation(self) -> Array:
        """(n,) [s], standard deviation of each motor."""
        return np.concatenate(self.errors).std(axis=0)

    @property
    def correlation(self) -> Array:
        """(n, n), between motors; 1 if all were read at one instant."""
        return np.asarray(np.corrcoef(np.concatenate(self.errors).T))

    def logged(self, motion: Stream, rng: np.random.Generator) -> Array:
        """Samples (N, n) [rad] that such a log holds of a motion, errors from a random place."""
        time = np.arange(motion.time[0], motion.time[-1], self.period)
        own = self.errors[rng.integers(len(self.errors))]
        rows = (np.arange(len(time)) + rng.integers(len(own))) % len(own)
        spline = CubicSpline(motion.time, motion.values)
        at = np.clip(time[:, None] + own[rows], motion.time[0], motion.time[-1])
        return np.column_stack([spline(at[:, j])[:, j] for j in range(at.shape[1])])


def timing_errors(logs: Sequence[Stream]) -> TimingErrors:
    """Timing errors of logs in which all motors move at the same time, or ValueError."""
    found = tuple(_of(log) for log in logs)
    if not all(len(errors) for errors in found):
        raise ValueError("timing errors need logs in which all motors move at the same time")
    steps = np.concatenate([np.diff(log.time) for log in logs])
    return TimingErrors(errors=found, period=float(np.median(steps)))


def _of(log: Stream) -> Array:
    """(N', n) [s], departure of each sample from the cubic over its window, over the rate there."""
    centres = np.arange(HALF, len(log.time) - HALF)
    rows = centres[:, None] + np.arange(-HALF, HALF + 1)
    t = log.time[rows] - log.time[centres][:, None]
    unit = np.abs(t).max()
    powers = np.linalg.pinv((t / unit)[:, :, None] ** np.arange(4))
    fit = powers[:, :2] @ log.values[rows]
    departure, rate = log.values[centres] - fit[:, 0], fit[:, 1] / unit
    moving = (np.abs(rate) > SLOWEST).all(axis=1)
    return departure[moving] / rate[moving]


REST = 0.5
"""[s] At both ends."""


def virtual_runs(
    path: WaypointPath, speed: float, n: int, seed: int, step: Callable[[], None] = lambda: None
) -> list[Stream]:
    """Motor logs of n runs of the virtual large robot at a speed [m/s], by its encoders at 250 Hz,
    each with noise of its own. Raises RuntimeError for one that has become unstable."""
    cell, timing = CELLS["large"], rest_to_rest(path.length, speed, PathLimits())
    time = np.arange(-REST, timing.duration + REST, LOG_PERIOD)
    reference = path.motor_angles(timing.at(time)[0])
    loaded = VirtualRobot(cell_model(cell, cell.xml)).load(reference)
    runs: list[Stream] = []
    for child in np.random.SeedSequence(seed).spawn(n):
        recording = loaded.run(rng=np.random.default_rng(child))
        if not np.isfinite(recording.motor_angle).all():
            raise RuntimeError(f"the virtual robot is unstable at {1e3 * speed:g} mm/s")
        runs.append(Stream(recording.time, recording.motor_angle))
        step()
    return runs


DRAWS = 10
"""Sets of logs of a perfectly repeated run."""
STEP = 0.002
"""[s] Of that run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AtSpeed:
    """Error and scatter of the motors' path at one programmed speed."""

    speed: float
    """[m/s]."""
    n_runs: int
    """Of the real robot."""
    real: PathScatter
    virtual: PathScatter
    """By its own log, which has no timing errors."""
    virtual_logged: PathScatter
    """By a log with the real one's timing errors."""
    timing: TimingErrors
    perfect: Array
    """(D,) [m], scatter that such logs show of runs without any, for each draw."""

    @property
    def unexplained(self) -> float:
        """Scatter of the real robot beyond that of its log [m], as a root of squares."""
        beyond = self.real.scatter**2 - float((self.perfect**2).mean())
        return float(np.sqrt(max(0.0, beyond)))


@dataclass(frozen=True, kw_only=True, eq=False)
class PathComparison:
    """Comparison at each speed of the logs."""

    path: WaypointPath
    speeds: tuple[AtSpeed, ...]


def compare_logs(
    arm: Arm, logs: PathLogs, runs: int, seed: int, step: Callable[[], None] = lambda: None
) -> PathComparison:
    """Compare logs with `runs` runs of the virtual large robot at each speed.

    Raises ValueError for logs of another robot, or of a path that was not followed to its end,
    RuntimeError where the virtual robot is unstable on it.
    """
    path = waypoint_path(compile(arm.robot), logs.position, logs.phi)
    rng = np.random.default_rng(seed)

    def one(speed: float, real: list[Stream]) -> AtSpeed:
        timing = timing_errors(real)
        virtual = virtual_runs(path, speed, runs, seed, step)
        return AtSpeed(
            speed=speed,
            n_runs=len(real),
            real=path_scatter(path, [log.values for log in real]),
            virtual=path_scatter(path, [log.values for log in virtual]),
            virtual_logged=path_scatter(path, [timing.logged(log, rng) for log in virtual]),
            timing=timing,
            perfect=perfect_scatter(path, speed, timing, len(real), rng),
        )

    return PathComparison(path=path, speeds=tuple(one(*each) for each in logs.logs.items()))


def perfect_scatter(
    path: WaypointPath, speed: float, timing: TimingErrors, n_runs: int, rng: np.random.Generator
) -> Array:
    """Scatter (D,) [m] that n logs show of a robot that follows the path exactly, for each draw."""
    time = np.arange(0.0, path.length / speed, STEP)
    exact = Stream(time, path.motor_angles(speed * time))
    if n_runs < 2:
        return np.array([np.nan])
    draws = ([timing.logged(exact, rng) for _ in range(n_runs)] for _ in range(DRAWS))
    return np.array([path_scatter(path, runs).scatter for runs in draws])
