"""Path of a tool through measured waypoints, and deviations of motor logs from it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import KDTree

from armside.arrays import Array
from armside.kinematics import CompiledRobot

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
