"""Limits of joints and drives along a path of the tool, as bounds on its speed and acceleration.

With phi(s) along the path, phi_dot = phi' v and phi_ddot = phi' a + phi'' v^2. The torque of the
rigid arm is linear in a and v^2,

    tau = M phi' a + (M phi'' + c(phi, phi')) v^2 + g,

so that its limit bounds both in a line. Friction takes its part of each drive first.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import UnreachableError, inverse_path
from armside.kinematics import compile as compile_robot
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from ..cut.path import Plane
from ..cut.profile_grid import Bounds, BoundsAt
from ..laser.setup import Setup
from ..moves.instructions import Dynamics
from ..part.chain import Chain, place
from ..robot.drives import Drives
from ..robot.statics import Statics

SPACING, TURN = 5e-3, 0.1
"""Largest distance [m] and angle [rad] between the places at which the arm is evaluated; limits are
linear between them, and may jump from one element of a path to the next."""
COARSE, MARGIN = 4.0, 0.05
"""Factor on both for a first look, and margin that it keeps from the limits: directions between two
of its places, 0.4 rad apart, differ from the linear by less than half of that."""
BESIDE = 1e-9
"""Distance of the outermost places of an element from its ends [m]."""
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
    joint_acceleration: tuple[float, ...] = Dynamics().joint_acceleration
    """(6,) [rad/s^2]."""

    def along(self, path: Chain) -> BoundsAt | None:
        """Limits along a path in the drawing; None where none can be reached.

        Raises ValueError where the path is out of reach or of the joints' ranges.
        """
        if not self._can_limit(self._at(path, _places(path, COARSE)), 1.0 - MARGIN):
            return None
        places = _places(path)
        known = self._at(path, places)
        if not self._can_limit(known):
            return None

        def at(s: Array) -> Bounds:
            def between(column: Array) -> Array:
                return np.interp(s, places, column)

            def table(values: Array) -> Array:
                return np.stack([between(column) for column in values.T], axis=1)

            return Bounds(
                speed=between(known.speed),
                along=table(known.along),
                bend=table(known.bend),
                offset=table(known.offset),
            )

        return at

    def _can_limit(self, known: Bounds, fraction: float = 1.0) -> bool:
        """Whether a joint can come to that fraction of its limit at the programmed speed."""
        acceleration = self.setup.limits.acceleration
        used = acceleration * np.abs(known.along) + np.abs(known.offset)
        used += self.speed**2 * np.abs(known.bend)
        return bool((fraction * known.speed < self.speed).any() or (used > fraction).any())

    def _at(self, path: Chain, s: Array) -> Bounds:
        phi = self._motors(path.point(s))
        slope, bend = self._derivatives(path, s, phi)
        limits, drives = self.setup.cell.limits, self.controller.model.drives
        speed = (np.array(limits.speed) / np.maximum(np.abs(slope), 1e-12)).min(axis=1)
        acceleration = np.array(self.joint_acceleration)
        torques = self._torques(phi, slope, bend)
        available = self._available(drives, slope)
        gravity, along, curved = (torque / available for torque in torques)
        return Bounds(
            speed=speed,
            along=np.hstack([slope / acceleration, along]),
            bend=np.hstack([bend / acceleration, curved]),
            offset=np.hstack([np.zeros_like(slope), gravity]),
        )

    def _derivatives(self, path: Chain, s: Array, phi: Array) -> tuple[Array, Array]:
        """phi' and phi'' (N, 6) by the arc length: J phi' = p', J phi'' = p'' - J' phi'."""
        robot = compile_robot(self.setup.cell.robot)
        heading, curvature = path.direction(s), path.curvature_at(s)
        along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        left = np.stack([-along[:, 1], along[:, 0]], axis=1)
        first, second = np.zeros((2, len(s), 6))
        first[:, :3] = along @ self.plane.axes[:, :2].T
        second[:, :3] = (curvature[:, np.newaxis] * left) @ self.plane.axes[:, :2].T
        J = robot.jacobian(np.ascontiguousarray(phi))
        slope: Array = np.asarray(np.linalg.solve(J, first[:, :, np.newaxis])[:, :, 0], np.float64)
        second -= robot.acceleration(
            np.ascontiguousarray(phi), np.ascontiguousarray(slope), np.zeros_like(phi)
        )
        bend = np.linalg.solve(J, second[:, :, np.newaxis])[:, :, 0]
        return slope, np.asarray(bend, np.float64)

    def _motors(self, points: Array) -> Array:
        tool = self.setup.tool_pose
        position = self.plane.to_base(points - self.middle)
        T = transform(from_quaternion(np.array(tool.quaternion)), position)
        cell = self.setup.cell
        try:
            start = inverse_path(cell.robot, self._first(T), None, cell.limits)[-1]
            return inverse_path(cell.robot, T, start, cell.limits)
        except UnreachableError as error:
            far = f"{1e3 * error.distance:.1f} mm outside the workspace of {cell.robot.name}"
            where = place(points[min(error.index, len(points) - 1)])
            said = f"the part is out of reach at {where}: the wrist would lie {far}"
            raise ValueError(said) from error

    def _first(self, T: Array) -> Array:
        """The way from the middle of the part, so that all paths have one branch of solutions."""
        way = np.repeat(T[:1], 20, axis=0)
        share = np.linspace(0.0, 1.0, 20)[:, np.newaxis]
        way[:, :3, 3] = self.plane.origin + share * (T[0, :3, 3] - self.plane.origin)
        return way

    def _torques(self, phi: Array, slope: Array, bend: Array) -> tuple[Array, Array, Array]:
        """(N, 6) each [N m], arm side: of gravity, per acceleration and per v^2 along the path."""
        statics, still = self.controller, np.zeros_like(phi)
        gravity = statics.motor_torque(statics.rigid_forces(phi, still, still))
        along = statics.motor_torque(statics.rigid_forces(phi, still, slope)) - gravity
        curved = statics.motor_torque(statics.rigid_forces(phi, slope, bend)) - gravity
        return gravity, along, curved

    def _available(self, drives: Drives, slope: Array) -> Array:
        """(N, 6) [N m], arm side, that friction at the highest speed leaves of the limit."""
        gear = np.abs(drives.gear)
        most = np.minimum(np.abs(slope) * self.speed, np.array(self.setup.cell.limits.speed))
        friction = gear * drives.coulomb_friction + gear**2 * drives.viscous_friction * most
        limit = DRIVE * gear * drives.torque_limit
        return np.maximum(limit - friction, 0.1 * limit)


def _places(path: Chain, coarser: float = 1.0) -> Array:
    """Arc lengths [m], ascending: each element from its begin to its end."""
    pieces = np.maximum(path.lengths / SPACING, np.abs(path.angle) / TURN) / coarser
    parts = np.ceil(pieces).astype(int) + 1
    inside = np.minimum(BESIDE, 0.25 * path.lengths)
    return np.concatenate(
        [
            np.linspace(begin + edge, end - edge, n)
            for begin, end, edge, n in zip(
                path.ends[:-1], path.ends[1:], inside, np.maximum(parts, 2), strict=True
            )
        ]
    )
