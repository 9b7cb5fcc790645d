"""Specification of a cut: contour, place, speed, and the robot individual that makes it."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from armside.arrays import Array, check_numbers
from armside.kinematics.robot_file import GearTerm

from ..cell import Cell, ToolPose, pose
from ..evaluation.tool_error import ToolError, tool_error
from ..instruments.imu import ImuCfg
from ..motion.contour import ArcsAndLines, Circle, ClosedCurve
from ..motion.path import CuttingPath, Plane
from ..motion.timing import PathLimits
from ..motion.tool_motion import ToolMotion, joint_reference, motion_notes, plan_cut
from ..notes import Note
from ..robot.effects import Effect
from ..robot.individual import Individual
from ..robot.spread import Drawn
from ..robot.statics import Statics, anticipated_shift, smoothed
from ..robot.virtual_robot import LOG_PERIOD
from ..robot_file.find import find_cell

MotionT = TypeVar("MotionT")
Row = dict[str, Any]
"""Measures by name, as `summary.json` has them."""
Ended = tuple[int, Sequence[ToolError]]
"""Iteration, and the true errors of its contours."""


class Timed(NamedTuple):
    """A contour in a motion, without leads."""

    name: str
    begin: float
    end: float
    """[s]."""


@dataclass(frozen=True, kw_only=True)
class Setup(ABC, Generic[MotionT]):
    """Robot individual with its tool at a pose of its cell, and what it cuts there. SI units.

    `Cut` is of one contour, `part_cut.PartCut` of all contours of a drawing.
    """

    robot: str | Cell = "large"
    """Name of a cell, its robot file, or a cell of one's own."""
    model: Path | None = None
    """MJCF in place of the cell's."""
    pose: str | ToolPose = "p1"
    """Centre of the contour or part and orientation of the tool: a named pose of the cell, or any.
    """
    limits: PathLimits = field(default_factory=PathLimits)
    """Limits of the controller for acceleration and jerk along the path."""
    payload: float | None = None
    """Mass of the tool [kg]; that of the model if None."""
    payload_known: bool = True
    """The controller knows the payload."""
    friction_spread: float = 0.02
    """Friction of each axis is uniform within +- this fraction of the nominal."""
    individual: Individual | Drawn | int | None = None
    """Parameters of the individual, or the seed they are drawn with; None: friction only. A bare
    seed stands for the individuals of thesis chapter 9: `Spread()`."""
    friction_drift: float = 0.0
    """Change of Coulomb and static friction since the robot was commissioned, relative."""
    temperature: float | None = None
    """Of the gears [deg C]; that of the model if None."""
    friction_feedforward: float | None = None
    """Fraction of friction that the controller feeds forward; that of the model if None."""
    without: tuple[Effect, ...] = ()
    """Effects of gears and drives that are left out, for ablations."""
    imu: ImuCfg | None = None
    """Unit at the tool."""
    across_tool: bool = False
    """In the plane perpendicular to the tool axis instead of the base x-y plane."""
    gear_error: tuple[GearTerm, ...] = ()
    """Transmission error of this individual that the controller knows: motors are asked for r -
    epsilon(r), so that the gears' outputs follow r, and estimators add epsilon to motor angles."""

    def __post_init__(self) -> None:
        check_numbers(self, "payload", "friction_spread", "friction_drift", "temperature")
        for effect in self.without:
            if not isinstance(effect, Effect):
                names = ", ".join(str(each) for each in Effect)
                raise ValueError(f"without takes effects, got {effect!r}. Effects: {names}")

    @property
    def cell(self) -> Cell:
        """The robot's cell. Raises ValueError for an unknown name or a wrong robot file."""
        return self.robot if isinstance(self.robot, Cell) else find_cell(self.robot)

    @property
    def tool_pose(self) -> ToolPose:
        """Centre and orientation. Raises ValueError for an unknown name."""
        return pose(self.pose, self.cell.poses) if isinstance(self.pose, str) else self.pose

    @property
    def plane(self) -> Plane:
        """Plane that is cut in, its origin at the pose."""
        origin = np.array(self.tool_pose.position)
        if self.across_tool:
            return Plane.perpendicular_to(self.tool_pose.tool_axis, origin)
        return Plane(origin)

    @abstractmethod
    def planned(self, nominal: Statics) -> tuple[MotionT, Array]:
        """Motion of the tool and its reference r, (N, n) [rad], as the controller makes them.

        Raises ValueError where the joint limits (where) or the reach (by how much) are left.
        """

    @abstractmethod
    def errors(
        self, motion: MotionT, time: Array, position: Array, *, edges: bool = True
    ) -> tuple[ToolError, ...]:
        """Errors of the contours in their order.

        time, position: (K,) [s] and (K, 3) [m], base axes, at the rate of the tracker.
        edges: of the cut edge as well, where there are such measures.
        """

    @abstractmethod
    def whole(self, motion: MotionT, errors: Sequence[ToolError]) -> ToolError:
        """Error of all contours together."""

    @abstractmethod
    def contours(self, motion: MotionT) -> Sequence[Timed]:
        """Contours in their order."""

    def turn_rate(self, motion: MotionT) -> float:
        """[turns/s], of the contour that is cut in the shortest time."""
        return max(1.0 / (contour.end - contour.begin) for contour in self.contours(motion))

    @abstractmethod
    def weights(self, motion: MotionT) -> Array:
        """(N, M), share of the correction of each contour in that of the run."""

    @abstractmethod
    def notes(self, motion: MotionT) -> Iterator[Note]:
        """Notes of the plan: what made it slower than asked for."""

    @abstractmethod
    def entries(
        self, motion: MotionT, contours: Sequence[Sequence[Row]], ends: Sequence[Ended]
    ) -> Row:
        """Entries of `summary.json` that other specifications lack.

        contours: measures of each contour [m], by iteration.
        ends: the first and the last iteration.
        """


SPIRAL_START = 0.6  # Fraction of its size at which a contour's spiral starts
SPIRAL_LEAD = 0.25  # Length of a spiral in turns: its bends have 0.4 of a circle's radius


class LeadIn(Enum):
    """Path from the start of the cut to the contour."""

    ARC = "arc"
    """Along the contour itself."""
    SPIRAL = "spiral"
    """Outwards from inside it."""


@dataclass(frozen=True, kw_only=True)
class Cut(Setup[ToolMotion]):
    """One contour cut by one robot individual. SI units."""

    contour: ClosedCurve | None = None
    """Contour around the origin of its plane; a circle of `radius` if None."""
    radius: float = 0.005
    """Programmed radius of the circle [m]."""
    speed: float = 0.040
    """Programmed speed along the path [m/s]."""
    lead_in: LeadIn = LeadIn.ARC

    def __post_init__(self) -> None:
        super().__post_init__()
        check_numbers(self, "radius", "speed")

    @property
    def curve(self) -> ClosedCurve:
        """Contour around the origin of its plane."""
        return Circle(self.radius) if self.contour is None else self.contour

    @property
    def path(self) -> CuttingPath:
        """Lead-in, one turn and lead-out."""
        plane = self.plane
        if self.lead_in is LeadIn.SPIRAL:
            return CuttingPath.around(self.curve, plane, lead=SPIRAL_LEAD, spiral=SPIRAL_START)
        return CuttingPath.around(self.curve, plane)

    def planned(self, nominal: Statics) -> tuple[ToolMotion, Array]:
        """Inverse kinematics of the programmed path; then again of the path shifted against the
        elastic deflection that the controller anticipates."""
        cell, path = self.cell, self.path
        motion, phi = plan_cut(
            path,
            self.tool_pose.quaternion,
            self.speed,
            cell.robot,
            cell.limits,
            start=cell.home,
            path_limits=self.limits,
            free_rotation=cell.free_rotation,
        )
        shift = anticipated_shift(nominal, phi, LOG_PERIOD)
        if isinstance(path.curve, ArcsAndLines):
            shift = smoothed(shift)
        free = cell.free_rotation
        return motion, joint_reference(
            motion, cell.robot, cell.limits, start=phi[0], shift=shift, free_rotation=free
        )

    def errors(
        self, motion: ToolMotion, time: Array, position: Array, *, edges: bool = True
    ) -> tuple[ToolError, ...]:
        return (tool_error(motion, time, position),)

    def whole(self, motion: ToolMotion, errors: Sequence[ToolError]) -> ToolError:
        return errors[0]

    def turn_rate(self, motion: ToolMotion) -> float:
        return motion.programmed_speed / motion.path.curve.length

    def contours(self, motion: ToolMotion) -> Sequence[Timed]:
        return (Timed("contour", *motion.contour_time),)

    def weights(self, motion: ToolMotion) -> Array:
        return np.ones((len(motion.time), 1))

    def notes(self, motion: ToolMotion) -> Iterator[Note]:
        return motion_notes(motion, self.limits)

    def entries(
        self, motion: ToolMotion, contours: Sequence[Sequence[Row]], ends: Sequence[Ended]
    ) -> Row:
        return {"reached_speed": motion.reached_speed}
