"""Limits of joints and drives along a path of the tool, as bounds on its speed and acceleration.

With phi(s) along the path, phi_dot = phi' v and phi_ddot = phi' a + phi'' v^2. The torque of the
rigid arm is linear in a and v^2,

    tau = M phi' a + (M phi'' + c(phi, phi')) v^2 + g,

so that its limit bounds both in a line. Friction takes its part of each drive first.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array
from armside.kinematics import Robot, UnreachableError, inverse_path
from armside.kinematics import compile as compile_robot
from armside.kinematics.inverse.closed_form import JointRangeError
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from ..motion.instructions import Dynamics
from ..motion.path import Plane
from ..motion.profile_grid import Bounds, BoundsAt
from ..part.arcs import Chain, place
from ..robot.drives import Drives
from ..robot.statics import Statics
from .specification import Setup

SPACING, TURN = 5e-3, 0.1
"""Largest distance [m] and angle [rad] between the places at which the arm is evaluated; limits are
linear between them, and may jump from one element of a path to the next."""
COARSE, MARGIN = 4.0, 0.05
"""Factor on both for a first look, and margin that it keeps from the limits: directions between two
of its places, 0.4 rad apart, differ from the linear by less than half of that."""
BESIDE = 1e-9
"""Distance of the outermost places of an element from its ends [m]."""
TOGETHER = 5000
"""Places at which the arm is evaluated at once: memory does not grow with the number of paths."""
STEPS = 20
"""Steps of the way from the middle of the part to a path."""
DRIVE = 0.9
"""Fraction of a torque limit that a plan may use: springs and the servo take the rest. ESTIMATE"""


@dataclass(frozen=True, eq=False)
class JointBounds:
    """Limits of a robot over a sheet."""

    setup: Setup
    controller: Statics
    plane: Plane
    middle: Array
    """(2,) [m], of the part in the drawing, which lies at the plane's origin."""
    speed: float
    """Highest speed along the path [m/s], for friction."""

    def along(self, paths: Sequence[Chain]) -> list[BoundsAt | None]:
        """Limits along each path in the drawing; None where none can be reached."""
        found: list[BoundsAt | None] = [None] * len(paths)
        near = [
            i
            for i, _, known in self._each(paths, range(len(paths)), COARSE)
            if self._can_limit(known, 1.0 - MARGIN)
        ]
        for i, places, known in self._each(paths, near):
            if self._can_limit(known):
                found[i] = _between(places, known)
        return found

    def _each(
        self, paths: Sequence[Chain], chosen: Sequence[int], coarser: float = 1.0
    ) -> Iterator[tuple[int, Array, Bounds]]:
        batch = list[tuple[Chain, Array]]()
        for n, i in enumerate(chosen, start=1):
            batch.append((paths[i], _places(paths[i], coarser)))
            sizes = [len(s) for _, s in batch]
            if sum(sizes) > TOGETHER or n == len(chosen):
                phi = self._motors([path.point(s) for path, s in batch])
                whole = self._bounds(phi, *self._derivatives(batch, phi))
                parts = zip(*(np.split(part, np.cumsum(sizes)[:-1]) for part in whole), strict=True)
                for k, (_, s), own in zip(chosen[n - len(batch) : n], batch, parts, strict=True):
                    yield k, s, Bounds(*own)
                batch = []

    def _can_limit(self, known: Bounds, fraction: float = 1.0) -> bool:
        """Whether a joint can come to that fraction of its limit at the programmed speed."""
        acceleration = self.setup.limits.acceleration
        used = acceleration * np.abs(known.along) + np.abs(known.offset)
        used += self.speed**2 * np.abs(known.bend)
        return bool((fraction * known.speed < self.speed).any() or (used > fraction).any())

    def _bounds(self, phi: Array, slope: Array, bend: Array) -> Bounds:
        limits, statics = self.setup.cell.limits, self.controller
        # Torques at the arm, of gravity, per acceleration and per v^2 along the path.
        gravity, along, curved = statics.motor_torque(statics.rigid_terms(phi, slope, bend))
        available = self._available(statics.model.drives, slope)
        acceleration = np.array(Dynamics().joint_acceleration)
        return Bounds(
            speed=(np.array(limits.speed) / np.maximum(np.abs(slope), 1e-12)).min(axis=1),
            along=np.hstack([slope / acceleration, (along - gravity) / available]),
            bend=np.hstack([bend / acceleration, (curved - gravity) / available]),
            offset=np.hstack([np.zeros_like(slope), gravity / available]),
        )

    def _derivatives(self, paths: Sequence[tuple[Chain, Array]], phi: Array) -> tuple[Array, Array]:
        """phi' and phi'' (N, 6) by the arc length: J phi' = p', J phi'' = p'' - J' phi'."""
        heading = np.concatenate([path.direction(s) for path, s in paths])
        curvature = np.concatenate([path.curvature_at(s) for path, s in paths])
        along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        left = np.stack([-along[:, 1], along[:, 0]], axis=1)
        first, second = np.zeros((2, len(phi), 6))
        first[:, :3] = along @ self.plane.axes[:, :2].T
        second[:, :3] = (curvature[:, np.newaxis] * left) @ self.plane.axes[:, :2].T
        robot, phi = compile_robot(self.setup.cell.robot), np.ascontiguousarray(phi)
        J = robot.jacobian(phi)

        def solved(twist: Array) -> Array:
            return np.asarray(np.linalg.solve(J, twist[:, :, np.newaxis])[:, :, 0], np.float64)

        slope = solved(first)
        at_rest = robot.acceleration(phi, np.ascontiguousarray(slope), np.zeros_like(phi))
        return slope, solved(second - at_rest)

    def _motors(self, paths: Sequence[Array]) -> Array:
        """(N, 6) [rad] at the points (M, 2) of all paths in the drawing.

        Each is reached from the middle of the part, and left by the same way back, so that all have
        one branch of solutions.
        """
        share, tour = np.linspace(0.0, 1.0, STEPS)[:, np.newaxis], list[Array]()
        own = list[NDArray[np.bool_]]()
        for points in paths:
            way = np.vstack([self.middle + share * (points[0] - self.middle), points])
            tour += [way, way[::-1]]
            own.append(np.repeat([False, True, False], [STEPS, len(points), len(way)]))
        drawn = np.vstack(tour)
        placed = self.plane.to_base(drawn - self.middle)
        return motors_at(self.setup, placed, drawn)[np.hstack(own)]

    def _available(self, drives: Drives, slope: Array) -> Array:
        """(N, 6) [N m], arm side, that friction at the highest speed leaves of the limit."""
        gear = np.abs(drives.gear)
        most = np.minimum(np.abs(slope) * self.speed, np.array(self.setup.cell.limits.speed))
        friction = gear * drives.coulomb_friction + gear**2 * drives.viscous_friction * most
        limit = DRIVE * gear * drives.torque_limit
        return np.maximum(limit - friction, 0.1 * limit)


def motors_at(setup: Setup, positions: Array, drawn: Array) -> Array:
    """(M, 6) [rad], motor angles at places of the tool (M, 3), all of one branch.

    Raises ValueError where one is out of reach or of the joints' ranges, with its place in the
    drawing, of (M, 2).
    """
    cell = setup.cell
    T = transform(from_quaternion(np.array(setup.tool_pose.quaternion)), positions)
    try:
        return inverse_path(cell.robot, T, None, cell.limits)
    except (UnreachableError, JointRangeError) as error:
        raise out_of_reach(error, place(drawn[error.index]), cell.robot) from error


def out_of_reach(error: UnreachableError | JointRangeError, where: str, robot: Robot) -> ValueError:
    """The error of a part of which a place cannot be reached."""
    if isinstance(error, JointRangeError):
        return ValueError(
            f"the part leaves the joint limits of {robot.name} at {where}: {error.passed}"
        )
    far = f"{1e3 * error.distance:.1f} mm outside the workspace of {robot.name}"
    return ValueError(f"the part is out of reach at {where}: the wrist would lie {far}")


def _between(places: Array, known: Bounds) -> BoundsAt:
    """Limits between places, linear."""
    table = np.column_stack(known)
    slope = np.diff(table, axis=0) / np.diff(places)[:, np.newaxis]
    width = np.cumsum([1, known.along.shape[1], known.bend.shape[1]])

    def at(s: Array) -> Bounds:
        inside = np.clip(s, places[0], places[-1])
        i = np.clip(np.searchsorted(places, inside, side="right") - 1, 0, len(slope) - 1)
        values = table[i] + (inside - places[i])[:, np.newaxis] * slope[i]
        speed, along, bend, offset = np.split(values, width, axis=1)
        return Bounds(speed=speed[:, 0], along=along, bend=bend, offset=offset)

    return at


def _places(path: Chain, coarser: float = 1.0) -> Array:
    """Arc lengths [m], ascending: each element from its begin to its end."""
    pieces = np.maximum(path.lengths / SPACING, np.abs(path.angle) / TURN) / coarser
    parts = np.maximum(np.ceil(pieces).astype(int) + 1, 2)
    inside = np.minimum(BESIDE, 0.25 * path.lengths)
    begins, ends = path.ends[:-1] + inside, path.ends[1:] - inside
    return np.concatenate([*map(np.linspace, begins, ends, parts)])
