"""Checks of measurements against the nominal robot, and the region in which a calibration holds.

What cannot be right is named, not fitted. Within the region each joint variable lies near those
that were fitted: harmonics do not extrapolate. The posterior's own standard deviation of a
predicted point does not exceed the fit's residual: geometry that was seen in one corner of the
workspace is not known in another.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..dh import Limits, Robot
from .error_model import ErrorModel
from .fit import Fit, jacobian_of_points
from .measurements import Measurements, register, unique_poses

STILL = 1e-3
"""Standard deviation of a motor angle [rad or m] below which the motor does not move."""
RIGID = 1e-3
"""[m] Deviation between two targets, at 90 % of the poses, from which one of them moves."""
MISFIT = 0.05
"""Residual of the nominal robot, relative to the spread of the points, that no error explains."""
EXPLAINED = 0.2
"""Part of that residual that a likely mistake may leave."""
ALONE = 0.3
"""Motion of the other targets, relative to that of one, up to which it alone is said to move."""
UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "kilometres": 1e3}
"""[m]"""
MIRRORED = {
    "x and y swapped": ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "y and z swapped": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "x and z swapped": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
    "the sign of x reversed": ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "the sign of y reversed": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "the sign of z reversed": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
}
"""Left-handed frames, symmetric matrices."""
OUT_OF_RANGE = 1.1
"""Motor angle relative to its limit from which the unit is doubted."""


PoseFunction = Callable[[Array], Array]
"""T_base_tool (N, 4, 4) of motor angles (N, n)."""


def check(robot: Robot, limits: Limits, data: Measurements) -> None:
    """Raise ValueError for measurements that cannot be of this robot; the message says why."""
    n = robot.n_joints
    if data.phi.shape[1] != n:
        raise ValueError(f"{robot.name} has {n} motors, the data have {data.phi.shape[1]}")
    _finite(data)
    needed, given = 4 * n + 6, 3 * (unique_poses(data.phi).max() + 1) * data.n_targets
    if given < needed:
        text = f"{len(data)} poses give {given} coordinates of distinct poses"
        raise ValueError(f"too few poses: {text}, {needed} are needed for {n} joints")
    for motor, spread in enumerate(data.phi.std(axis=0), 1):
        if spread < STILL:
            still = f"motor {motor} does not move (standard deviation {spread:.1g})"
            raise ValueError(f"{still}: its errors cannot be seen")
    largest = np.abs(data.phi).max(axis=0)
    bound = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
    worst = int((largest / bound).argmax())
    if largest[worst] > OUT_OF_RANGE * bound[worst]:
        unit = " are the angles in degrees?" if largest[worst] > 2.0 * bound[worst] else ""
        reached = f"motor_angle_{worst + 1} reaches {largest[worst]:.3g}"
        limit = f"its limit is {bound[worst]:.3g} rad"
        raise ValueError(f"{reached}, {limit};{unit or ' is it this robot?'}")
    _rigid_targets(data)
    _fits(robot, data)


def _finite(data: Measurements) -> None:
    if np.isinf(data.points).any():
        raise ValueError("a target has an infinite coordinate")
    partly = np.isfinite(data.points).sum(axis=2) % 3 != 0
    if partly.any():
        row, target = np.argwhere(partly)[0]
        where = f"target {target + 1} in row {data.row[row]}"
        raise ValueError(f"{where} has some coordinates and lacks others")
    for target in range(data.n_targets):
        if not np.isfinite(data.points[:, target]).any():
            raise ValueError(f"target {target + 1} was never seen")


def _rigid_targets(data: Measurements) -> None:
    """Name the target that moves against all others."""
    moved: dict[tuple[int, int], float] = {}
    for i, j in combinations(range(data.n_targets), 2):
        distance = np.linalg.norm(data.points[:, i] - data.points[:, j], axis=1)
        distance = distance[np.isfinite(distance)]
        if distance.size:
            moved[i, j] = float(np.quantile(np.abs(distance - np.median(distance)), 0.9))
    for target in range(data.n_targets):
        own = [value for pair, value in moved.items() if target in pair]
        others = [value for pair, value in moved.items() if target not in pair]
        if own and min(own) > RIGID and max(others, default=0.0) < max(RIGID, ALONE * min(own)):
            named = f"target {target + 1} moves" if others else "the two targets move"
            raise ValueError(f"{named} against the tool by {1e3 * min(own):.3g} mm")
    if moved and max(moved.values()) > RIGID:
        most = 1e3 * max(moved.values())
        raise ValueError(f"the targets move against each other by {most:.3g} mm")


def _fits(robot: Robot, data: Measurements) -> None:
    """Compare with the nominal robot, and with it under likely mistakes."""
    pose = ErrorModel(robot).nominal_pose
    reach = _spread(pose(data.phi)[:, None, :3, 3])
    ratio = _spread(data.points) / reach
    if not 0.1 < ratio < 10.0:
        _scaled(pose, data, ratio, reach)
    rms = _misfit(pose, data)
    if rms < MISFIT * reach:
        return
    text = f"the data do not fit {robot.name}: {1e3 * rms:.3g} mm RMS after registration"
    for mistake, changed in _mistakes(pose, data):
        if (left := _misfit(pose, changed)) < EXPLAINED * rms:
            raise ValueError(f"{text}, {1e3 * left:.3g} mm with {mistake}")
    raise ValueError(text)


def _scaled(pose: PoseFunction, data: Measurements, ratio: float, reach: float) -> None:
    """Name the unit in which the points fit the robot, or else that in which they spread alike."""
    fitting = [
        unit
        for unit, factor in UNITS.items()
        if _misfit(pose, replace(data, points=factor * data.points)) < MISFIT * reach
    ]
    alike = [unit for unit in ("millimetres", "kilometres") if 0.1 < ratio * UNITS[unit] < 10.0]
    if named := [*fitting, *alike][:1]:
        text = f"points spread {ratio:.3g} times as far as the robot moves"
        raise ValueError(f"{text}: are they in {named[0]}?")


def _mistakes(pose: PoseFunction, data: Measurements) -> Iterator[tuple[str, Measurements]]:
    """Likely mistakes, and the data without them.

    All mirrored frames fit alike, as a rotation is between any two: that is named whose axes are
    nearest to those of the base.
    """
    phi, n = data.phi, data.phi.shape[1]
    yield "angles taken for degrees", replace(data, phi=np.degrees(phi))
    yield "angles taken for radians", replace(data, phi=np.radians(phi))
    for i, j in combinations(range(n), 2):
        order = np.arange(n)
        order[[i, j]] = j, i
        yield f"motors {i + 1} and {j + 1} swapped", replace(data, phi=phi[:, order])
    for i, sign in enumerate(1.0 - 2.0 * np.eye(n), 1):
        yield f"the sign of motor {i} reversed", replace(data, phi=phi * sign)
    frames = {name: replace(data, points=data.points @ np.array(M)) for name, M in MIRRORED.items()}
    T = pose(phi)
    name = max(frames, key=lambda name: float(np.trace(register(T, frames[name]).R)))
    yield f"the frame of the targets mirrored, {name}", frames[name]


def _misfit(pose: PoseFunction, data: Measurements) -> float:
    T = pose(data.phi)
    R, p, targets, _ = register(T, data)
    nominal = T[:, None, :3, 3] + np.einsum("nij,tj->nti", T[:, :3, :3], targets)
    error = np.linalg.norm(data.points - (nominal @ R.T + p), axis=2)
    return float(np.sqrt(np.nanmedian(error**2)))


def _spread(points: Array) -> float:
    """Root mean square distance from the median point [m]."""
    away = np.linalg.norm(points - np.nanmedian(points, axis=0), axis=2)
    return float(np.sqrt(np.nanmedian(away**2)))


MARGIN = 0.1
"""[rad or m] Largest distance of a joint variable from the range of the fitted ones."""
GAP = 0.4
"""[rad or m] Largest distance from the nearest fitted one within their range."""
TRUSTED = 3.0
"""Standard deviation of a predicted point, relative to the root mean square residual of the fit of
the geometry. The posterior is two to three times too careful where few poses were fitted."""


@dataclass(frozen=True, eq=False)
class Region:
    """Configurations that a fit may be used for."""

    robot: Robot
    values: tuple[Array, ...]
    """Fitted values of each joint variable, sorted."""
    fit: Fit
    largest: float
    """Standard deviation of a predicted point that is still trusted [m]."""

    def contains(self, phi: Array) -> NDArray[np.bool_]:
        """True for each configuration (N, n) in the region."""
        inside = self.standard_deviation(phi) <= self.largest
        for values, fitted in zip(self.robot.joint_variables(phi).T, self.values, strict=True):
            place = np.searchsorted(fitted, values)
            left = np.abs(values - fitted[np.maximum(place - 1, 0)])
            right = np.abs(values - fitted[np.minimum(place, len(fitted) - 1)])
            within = (place > 0) & (place < len(fitted))
            inside &= np.minimum(left, right) <= np.where(within, GAP, MARGIN)
        return inside

    def standard_deviation(self, phi: Array) -> Array:
        """Standard deviation (N,) of the predicted first target [m], by the posterior."""
        J = jacobian_of_points(self.fit, phi)
        return np.sqrt(((J @ self.fit.covariance) * J).sum(axis=(1, 2)))


def region(fit: Fit, geometry: Fit) -> Region:
    """Region of a fit; `geometry` is the fit of the same poses without joint errors."""
    robot = fit.problem.model.robot
    q = robot.joint_variables(fit.problem.data.phi)
    lengths = geometry.lengths[np.isfinite(geometry.lengths)]
    rms = float(np.sqrt(np.mean(lengths**2)))
    return Region(robot, tuple(np.unique(column) for column in q.T), fit, TRUSTED * rms)
