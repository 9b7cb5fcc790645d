"""Motion of the tool over a cutting path, and the joint reference that produces it.

`cut` times a path and samples it at the log rate. `joint_reference` is its inverse kinematics under
joint limits. `plan_cut` does both, at the highest speed that path and joint limits allow.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, freeze_rows
from armside.kinematics import (
    Limits,
    Robot,
    UnsolvableGeometryError,
    inverse_numeric_path,
    inverse_path,
)
from armside.kinematics.rigid import transform
from armside.kinematics.rotation import from_quaternion

from ..notes import Cause, Note
from .contour import ClosedCurve
from .path import CuttingPath, Plane
from .timing import PathLimits, Timing, rest_to_rest

STEP = 0.004
"""[s], of the log."""
REST_AFTER = 0.35
"""[s]."""
LimitHit = tuple[str, int, float]
"""(limit, axis, first time [s]); axis 0 is the tool on its path."""


@dataclass(frozen=True, kw_only=True)
class ToolMotion:
    """Tool path in time, at rest at both ends. Row i of the arrays belongs to time[i]."""

    time: Array
    """(N,) [s], from 0."""
    position: Array
    quaternion: Array
    """(N, 3) [m], base axes, and (N, 4), base to tool."""
    arc_length: Array
    """(N,) [m]."""
    on_contour: NDArray[np.bool_]
    """(N,), True on the contour, at constant speed and without leads."""
    contour_time: tuple[float, float]
    """Exact start and end of the contour [s], between samples."""
    programmed_speed: float
    reached_speed: float
    """[m/s], on the contour."""
    limits_hit: tuple[LimitHit, ...]
    path: CuttingPath
    """Path with leads that are long enough to reach the speed before the contour."""
    timing: Timing
    rest_before: float
    """[s]."""

    def __post_init__(self) -> None:
        freeze_rows(self, "time", "position", "quaternion", "arc_length", "on_contour")

    @property
    def plane(self) -> Plane:
        """Plane of the contour."""
        return self.path.plane

    @property
    def curve(self) -> ClosedCurve:
        """The contour."""
        return self.path.curve

    @property
    def outline(self) -> tuple[Array, ...]:
        """(500, 2) [m], points of the contour in its plane, by which paths are told apart."""
        s = np.linspace(0.0, self.curve.length, 500, endpoint=False)
        return (self.curve.point(s),)

    @property
    def motion_end(self) -> float:
        """[s], at which it rests again."""
        return self.rest_before + self.timing.duration

    def position_at(self, time: ArrayLike) -> Array:
        """Programmed tool position at any times [s], shape (..., 3) [m]."""
        s, _, _ = self.timing.at(np.asarray(time, dtype=np.float64) - self.rest_before)
        return self.path.position(s)

    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the times [s] on the contour, such as those of the laser tracker."""
        first, last = self.contour_time
        t = np.asarray(time, dtype=np.float64)
        return (t >= first) & (t < last)


def cut(
    path: CuttingPath,
    quaternion: ArrayLike,
    speed: float,
    *,
    limits: PathLimits | None = None,
    rest_before: float = 0.28,
) -> ToolMotion:
    """Motion along `path` at `speed` [m/s] with constant tool orientation, from rest to rest.

    The speed is lowered to the limit of the smallest radius; leads that are too short for the ramps
    are lengthened, so that the whole contour is cut at constant speed. The rests are those of the
    calibrated record (0.16 s hold and 0.12 s rest; 0.35 s).

    Raises ValueError for a speed out of range, or a quaternion of zero length.
    """
    if not (np.isfinite(speed) and speed > 0.0):
        raise ValueError(f"speed must be > 0 m/s, got {speed}")
    q = np.asarray(quaternion, dtype=np.float64)
    if q.shape != (4,) or not np.all(np.isfinite(q)) or np.linalg.norm(q) < 1e-9:
        raise ValueError(f"quaternion must be four finite numbers, not all zero, got {quaternion}")
    limits, programmed = limits or PathLimits(), float(speed)
    reached = min(programmed, limits.cornering_speed(path.smallest_radius))
    ramp = limits.ramp_length(reached)
    path = replace(path, lead_in=max(path.lead_in, ramp), lead_out=max(path.lead_out, ramp))
    timing = rest_to_rest(path.length, reached, limits)
    cruise, _ = timing.cruise
    s_cruise, cruise_speed, _ = timing.at(cruise)
    first = float(rest_before + cruise + (path.lead_in - s_cruise) / cruise_speed)
    last = first + path.curve.length / float(cruise_speed)
    n_samples = int(np.ceil((rest_before + timing.duration + REST_AFTER) / STEP - 1e-9)) + 1
    time: Array = np.arange(n_samples, dtype=np.float64) * STEP
    s, _, _ = timing.at(time - rest_before)
    # Limits of acceleration reached: across the path (lower speed) and along it (longer ramp).
    hits: list[LimitHit] = []
    if reached < programmed:
        hits.append(("centripetal_acceleration", 0, rest_before + cruise))
    steep = np.abs(timing.state[:, 2]) >= limits.acceleration * (1.0 - 1e-9)
    if steep.any():
        hits.append(("path_acceleration", 0, rest_before + float(timing.start[steep.argmax()])))
    return ToolMotion(
        time=time,
        position=path.position(s),
        quaternion=np.tile(q / np.linalg.norm(q), (n_samples, 1)),
        arc_length=s,
        on_contour=(time >= first) & (time < last),
        contour_time=(first, last),
        programmed_speed=programmed,
        reached_speed=reached,
        limits_hit=tuple(hits),
        path=path,
        timing=timing,
        rest_before=rest_before,
    )


class Positions(Protocol):
    """Poses of the tool at the log rate."""

    @property
    def position(self) -> Array:
        """(N, 3) [m], base axes."""
        ...

    @property
    def quaternion(self) -> Array:
        """(N, 4), base to tool."""
        ...


def joint_reference(
    motion: Positions,
    robot: Robot,
    limits: Limits,
    *,
    start: ArrayLike | None = None,
    shift: Array | None = None,
    free_rotation: bool = False,
) -> Array:
    """Joint reference (N, n) [rad], arm side, of a tool motion: one branch of solutions throughout.

    By a closed form where the robot has one, else by numeric inverse kinematics along the path.

    Args:
        start: (n,) [rad], selects the nearest solution; zero pose by default.
        shift: (N, 3) [m], subtracted from the programmed positions: an anticipated deflection.
        free_rotation: positions alone are followed, whatever the tool's orientation.

    Raises UnreachableError for a position out of reach, ValueError for one outside of the limits.
    """
    position = motion.position if shift is None else motion.position - shift
    near = np.zeros(robot.n_joints) if start is None else start
    if free_rotation:
        return inverse_numeric_path(robot, position, near, limits=limits)
    T_base_tool = transform(from_quaternion(motion.quaternion), position)
    try:
        return inverse_path(robot, T_base_tool, start, limits)
    except UnsolvableGeometryError:
        return inverse_numeric_path(robot, T_base_tool, near, limits=limits)


def plan_cut(
    path: CuttingPath,
    tool_quaternion: ArrayLike,
    speed: float,
    robot: Robot,
    joint_limits: Limits,
    *,
    start: ArrayLike | None = None,
    path_limits: PathLimits | None = None,
    free_rotation: bool = False,
) -> tuple[ToolMotion, Array]:
    """Motion of a cut and its joint reference (N, n) [rad], within path and joint limits.

    Where a joint would be too fast, the whole cut is slowed down and `limits_hit` names the joint.
    """
    reached, slowed = speed, ()
    while True:
        motion = cut(path, tool_quaternion, reached, limits=path_limits)
        phi = joint_reference(motion, robot, joint_limits, start=start, free_rotation=free_rotation)
        use = np.abs(np.gradient(phi, STEP, axis=0)) / np.array(joint_limits.speed)
        if use.max() <= 1.0:
            break
        axis = int(np.argmax(use.max(axis=0)))
        slowed = (("joint_speed", axis + 1, float(motion.time[np.argmax(use[:, axis] > 1.0)])),)
        reached = motion.reached_speed / use.max() * (1.0 - 1e-6)
    hits = motion.limits_hit + slowed
    return replace(motion, programmed_speed=float(speed), limits_hit=hits), phi


def motion_notes(motion: ToolMotion, limits: PathLimits | None = None) -> Iterator[Note]:
    """Notes of a planned motion. limits: of its planner; None where they are not known."""
    value = "the acceleration limit" if limits is None else f"{limits.acceleration:g} m/s^2"
    radius = f"{1e3 * motion.path.smallest_radius:.3g} mm"
    why = {
        "centripetal_acceleration": f"{value} across the path at a radius of {radius}",
        "joint_speed": "speed limit of axis {axis}",
    }
    causes = [why[name].format(axis=axis) for name, axis, _ in motion.limits_hit if name in why]
    if causes:
        asked, reached = 1e3 * motion.programmed_speed, 1e3 * motion.reached_speed
        lowered = f"the speed is lowered from {asked:.4g} to {reached:.4g} mm/s"
        yield Note(cause=Cause.SPEED, text=f"{lowered}: {'; '.join(causes)}")
    if any(name == "path_acceleration" for name, _, _ in motion.limits_hit):
        ramps = f"the ramps take longer: {value} along the path"
        yield Note(cause=Cause.ACCELERATION, text=ramps)
