"""Path of a tool through measured waypoints, motor logs along it, and their deviations from it.

Logs are those of an ABB IRB6640, rpiRobotics/ARM-21-02-F-19-Robot-Motion-Program. A folder has
command.csv, waypoints as a motion program (p_bp: position of the tool [mm], q_bp: motor angles
[rad]), and logs *_vSPEED_*.csv of repeated runs: timestamp [s], cmd_num (-1 before the start, else
the command under way), J1 .. J6 [deg]. SPEED is the programmed one [mm/s].
"""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from armside.arrays import Array, check_recorded_time
from armside.kinematics import CompiledRobot

from ...records.files import LARGEST_DATA, check_file
from ..recorded_motion import Stream

MM = 1e-3
NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
SPEED = re.compile(r"_v(\d+\.?\d*)_")
FEWEST = 30
"""Waypoints and samples of a log."""
SLOWEST, FASTEST = 5e-3, 5.0
"""[m/s], programmed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PathLogs:
    """Waypoints of a path, and the logs of repeated runs along it."""

    position: Array
    """(W, 3) [m], of the tool, base axes."""
    phi: Array
    """(W, 6) [rad], motor angles there."""
    logs: dict[float, list[Stream]]
    """(N, 6) [rad] of each run after the approach to the path, by programmed speed [m/s]."""


def read_path_logs(folder: Path) -> PathLogs:
    """Waypoints and logs of a folder. Raises ValueError for files that are missing or damaged."""
    if not (folder / "command.csv").is_file():
        raise ValueError(f"{folder} is no folder of path logs: it needs command.csv")
    position, phi = _waypoints(check_file(folder / "command.csv", LARGEST_DATA))
    files = [file for file in sorted(folder.glob("*.csv")) if SPEED.search(file.name)]
    if not files:
        raise ValueError(f"{folder} has no logs: names must hold the speed, as in run_0_v75.0_.csv")
    logs: dict[float, list[Stream]] = {}
    for speed, log in map(_log, files):
        logs.setdefault(speed, []).append(log)
    return PathLogs(position=position, phi=phi, logs=dict(sorted(logs.items())))


def _waypoints(file: Path) -> tuple[Array, Array]:
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    found = [[_numbers(row.get(name)) for row in rows] for name in ("p_bp", "q_bp")]
    for name, width, values in zip(("p_bp", "q_bp"), (3, 6), found, strict=True):
        if wrong := [k + 1 for k, one in enumerate(values) if len(one) != width]:
            raise ValueError(f"{file.name}: row {wrong[0]} must have {width} numbers in {name}")
    if len(rows) < FEWEST:
        raise ValueError(f"{file.name}: at least {FEWEST} waypoints are needed, got {len(rows)}")
    return MM * np.array(found[0]), np.array(found[1])


def _numbers(text: str | None) -> list[float]:
    return [float(number) for number in NUMBER.findall((text or "").replace("array", ""))]


def _log(file: Path) -> tuple[float, Stream]:
    match = SPEED.search(file.name)
    assert match
    try:
        table = np.loadtxt(check_file(file, LARGEST_DATA), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from error
    if table.shape[1] != 8:
        raise ValueError(f"{file.name} must have 8 columns, got {table.shape[1]}")
    under_way = table[:, 1] > table[table[:, 1] >= 0.0, 1].min(initial=np.inf)
    rows = np.flatnonzero(under_way & np.isfinite(table).all(axis=1))
    table = table[rows]
    if len(table) < FEWEST:
        raise ValueError(f"{file.name}: {len(table)} samples under way, at least {FEWEST} needed")
    check_recorded_time(file.name, table[:, 0], rows)
    speed = MM * float(match.group(1))
    if not SLOWEST <= speed <= FASTEST:
        text = f"from {SLOWEST / MM:g} to {FASTEST / MM:g} mm/s"
        raise ValueError(f"{file.name}: the speed must be {text}, got {speed / MM:g}")
    return speed, Stream(table[:, 0], np.radians(table[:, 2:]))


POINTS = 20001
"""Of the path, between which the foot of a perpendicular is interpolated."""
CONSTANT = (0.15, 0.85)
"""Part of the path, as fractions of its length, at constant speed: what is judged."""
GRID = 800
"""Places on that part."""
SHORTEST, LONGEST = 0.05, 10.0
"""[m] Of a path."""
MISFIT = 2e-3
"""[m] RMS distance of waypoints from the robot's tool, beyond which it is another robot."""


@dataclass(frozen=True, eq=False)
class WaypointPath:
    """Path of a tool that is fixed to the last frame of a robot."""

    robot: CompiledRobot
    position: Array
    """(W, 3) [m]."""
    phi: Array
    """(W, n) [rad]."""
    tool: Array
    """(3,) [m], the tool in the robot's last frame."""
    misfit: float
    """[m], RMS distance of the waypoints from the tool."""

    @cached_property
    def station(self) -> Array:
        """(W,) [m], arc length of the waypoints."""
        steps = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length(self) -> float:
        """[m]."""
        return float(self.station[-1])

    @cached_property
    def normal(self) -> Array:
        """(3,), normal of the plane that fits the path best."""
        return np.linalg.svd(self.position - self.position.mean(axis=0))[2][2]

    def motor_angles(self, station: Array) -> Array:
        """(N, n) [rad] at arc lengths (N,)."""
        return CubicSpline(self.station, self.phi)(station)

    @cached_property
    def grid(self) -> Array:
        """(G,) [m], arc lengths at which runs are compared."""
        return self.length * np.linspace(*CONSTANT, GRID)

    def deviation(self, phi: Array) -> tuple[Array, Array]:
        """Arc length (N,) and deviation (N, 3) [m] across the path of motor angles (N, n)."""
        T = self.robot.pose(np.ascontiguousarray(phi))
        p = T[:, :3, 3] + T[:, :3, :3] @ self.tool
        tree, points, tangents = self._dense
        foot = np.asarray(tree.query(p)[1])
        e = p - points[foot]
        along = (e * tangents[foot]).sum(axis=1)
        station = self.length * foot / (POINTS - 1) + along
        return station, e - along[:, None] * tangents[foot]

    @cached_property
    def _dense(self) -> tuple[KDTree, Array, Array]:
        spline = CubicSpline(self.station, self.position)
        stations = np.linspace(0.0, self.length, POINTS)
        points, tangents = spline(stations), spline(stations, 1)
        return KDTree(points), points, tangents / np.linalg.norm(tangents, axis=1)[:, None]

    def on_grid(self, phi: Array) -> Array:
        """(G, 3) [m], deviation of a run at the grid. Raises ValueError where it does not pass."""
        station, e = self.deviation(phi)
        ahead = station > np.concatenate([[-np.inf], np.maximum.accumulate(station)[:-1]])
        if not ahead.any() or station[0] > self.grid[0] or station.max() < self.grid[-1]:
            raise ValueError("a log does not pass the whole path")
        rows = (np.interp(self.grid, station[ahead], e[ahead, axis]) for axis in range(3))
        return np.column_stack(list(rows))


def waypoint_path(robot: CompiledRobot, position: Array, phi: Array) -> WaypointPath:
    """Path with the tool that fits the waypoints best. Raises ValueError for another robot."""
    T = robot.pose(np.ascontiguousarray(phi))
    own = np.einsum("nji,nj->ni", T[:, :3, :3], position - T[:, :3, 3])
    tool = own.mean(axis=0)
    if not SHORTEST <= np.linalg.norm(np.diff(position, axis=0), axis=1).sum() <= LONGEST:
        raise ValueError(f"the path must be {SHORTEST:g} to {LONGEST:g} m long: are they in mm?")
    misfit = float(np.sqrt(((own - tool) ** 2).sum(axis=1).mean()))
    if misfit > MISFIT:
        text = f"waypoints lie {1e3 * misfit:.3g} mm RMS off a tool fixed to"
        raise ValueError(f"{text} {robot.robot.name}: is it this robot?")
    return WaypointPath(robot, position, phi, tool, misfit)


@dataclass(frozen=True, kw_only=True, eq=False)
class PathScatter:
    """Error of repeated runs across the path, motor side, at constant speed."""

    error: float
    """[m], RMS of the mean run, its mean vector removed."""
    error_in_plane: float
    """[m], the same in the plane of the path."""
    scatter: float
    """[m], standard deviation of a run about the mean run; NaN for one."""


def path_scatter(path: WaypointPath, runs: Sequence[Array]) -> PathScatter:
    """Measures of runs (N, n) [rad] along one path."""
    e = np.array([path.on_grid(phi) for phi in runs])
    mean = e.mean(axis=0) - e.mean(axis=(0, 1))
    flat = mean - np.outer(mean @ path.normal, path.normal)
    several = len(runs) > 1
    return PathScatter(
        error=float(np.sqrt((mean**2).sum(axis=1).mean())),
        error_in_plane=float(np.sqrt((flat**2).sum(axis=1).mean())),
        scatter=float(np.sqrt(e.var(axis=0, ddof=1).sum(axis=1).mean())) if several else np.nan,
    )
