"""Specification of a cut: contour, place, speed, and the robot individual that makes it."""

from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

import numpy as np

from ..cell import CELLS, Cell, ToolPose, pose
from ..cut.contour import Circle, ClosedCurve
from ..cut.path import CuttingPath, Plane
from ..cut.timing import PathLimits
from ..instruments.imu import ImuCfg
from ..robot.effects import Effect
from ..robot.individual import Individual
from ..robot.spread import Drawn

SPIRAL_START = 0.6  # Fraction of its size at which a contour's spiral starts
SPIRAL_LEAD = 0.25  # Length of a spiral in turns: its bends have 0.4 of a circle's radius


class LeadIn(Enum):
    """Path from the start of the cut to the contour."""

    ARC = "arc"
    """Along the contour itself."""
    SPIRAL = "spiral"
    """Outwards from inside it."""


@dataclass(frozen=True, kw_only=True)
class Cut:
    """One cut by one robot individual. SI units."""

    robot: str | Cell = "large"
    """Name of a cell, or a cell of one's own."""
    model: Path | None = None
    """MJCF in place of the cell's."""
    pose: str | ToolPose = "p1"
    """Centre of the contour and orientation of the tool: a named pose of the cell, or any."""
    contour: ClosedCurve | None = None
    """Contour around the origin of its plane; a circle of `radius` if None."""
    radius: float = 0.005
    """Programmed radius of the circle [m]."""
    speed: float = 0.040
    """Programmed speed along the path [m/s]."""
    across_tool: bool = False
    """In the plane perpendicular to the tool axis instead of the base x-y plane."""
    lead_in: LeadIn = LeadIn.ARC
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

    def __post_init__(self) -> None:
        for effect in self.without:
            if not isinstance(effect, Effect):
                names = ", ".join(str(each) for each in Effect)
                raise ValueError(f"without takes effects, got {effect!r}. Effects: {names}")

    @property
    def cell(self) -> Cell:
        """The robot's cell. Raises ValueError for an unknown name."""
        if isinstance(self.robot, Cell):
            return self.robot
        if self.robot not in CELLS:
            raise ValueError(f"Unknown robot {self.robot!r}. Robots: {', '.join(CELLS)}")
        return CELLS[self.robot]

    @property
    def tool_pose(self) -> ToolPose:
        """Centre and orientation. Raises ValueError for an unknown name."""
        return pose(self.pose, self.cell.poses) if isinstance(self.pose, str) else self.pose

    @property
    def curve(self) -> ClosedCurve:
        """Contour around the origin of its plane."""
        return Circle(self.radius) if self.contour is None else self.contour

    @property
    def path(self) -> CuttingPath:
        """Lead-in, one turn and lead-out."""
        origin = np.array(self.tool_pose.position)
        plane = Plane(origin)
        if self.across_tool:
            plane = Plane.perpendicular_to(self.tool_pose.tool_axis, origin)
        if self.lead_in is LeadIn.SPIRAL:
            return CuttingPath.around(self.curve, plane, lead=SPIRAL_LEAD, spiral=SPIRAL_START)
        return CuttingPath.around(self.curve, plane)
