"""Real motor logs of a path beside runs of the virtual robot along it, by speed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import Arm, compile

from ..measured.abb_logs import PathLogs
from ..measured.motion import Stream
from .timing_errors import TimingErrors, timing_errors
from .virtual_runs import virtual_runs
from .waypoint_path import PathScatter, WaypointPath, path_scatter, phi_of, waypoint_path

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

    Raises:
        ValueError: logs of another robot, or of a path that was not followed to its end.
        RuntimeError: the virtual robot is unstable on this path.
    """
    path = waypoint_path(compile(arm.robot), logs.position, logs.phi)
    rng = np.random.default_rng(seed)

    def one(speed: float) -> AtSpeed:
        real = [log.motors for log in logs.logs if log.speed == speed]
        timing = timing_errors(real)
        virtual = virtual_runs(path, speed, runs, seed, step)
        return AtSpeed(
            speed=speed,
            n_runs=len(real),
            real=path_scatter(path, phi_of(real)),
            virtual=path_scatter(path, phi_of(virtual)),
            virtual_logged=path_scatter(path, [timing.logged(log, rng) for log in virtual]),
            timing=timing,
            perfect=perfect_scatter(path, speed, timing, len(real), rng),
        )

    return PathComparison(path=path, speeds=tuple(one(speed) for speed in logs.speeds))


def perfect_scatter(
    path: WaypointPath, speed: float, timing: TimingErrors, n_runs: int, rng: np.random.Generator
) -> Array:
    """Scatter (D,) [m] that n logs show of a robot that follows the path exactly, for each draw."""
    time = np.arange(0.0, path.length / speed, STEP)
    exact = Stream(time, path.motor_angles(speed * time))

    def draw() -> float:
        return path_scatter(path, [timing.logged(exact, rng) for _ in range(n_runs)]).scatter

    return np.array([draw() for _ in range(DRAWS)] if n_runs > 1 else [np.nan])
