"""What is to be cut: a contour, where, how it is entered and how fast."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..cell import ToolPose
from .contour import Circle, ClosedCurve
from .path import CuttingPath, Plane
from .timing import PathLimits

SPIRAL_START = 0.6
"""Share of its size on which a contour's spiral starts."""
SPIRAL_LEAD = 0.25
"""Length of a spiral in turns: long enough to bend with 0.4 of a circle's radius."""


class LeadIn(Enum):
    """How the cut reaches its contour."""

    ARC = "arc"
    """Along the contour itself."""
    SPIRAL = "spiral"
    """Outwards from inside it."""


@dataclass(frozen=True, kw_only=True)
class CutTask(ABC):
    """A contour to be cut."""

    pose: ToolPose
    """Its position is the contour's centre; its orientation is kept."""
    speed: float = 0.040
    """Programmed [m/s]."""
    across_tool: bool = False
    """In the plane perpendicular to the tool axis instead of the base x-y plane."""
    lead_in: LeadIn = LeadIn.ARC
    limits: PathLimits | None = None
    """Of the controller, for acceleration and jerk along the path; its own if None."""

    @property
    @abstractmethod
    def curve(self) -> ClosedCurve:
        """The contour, around the origin of its plane."""

    @property
    def path(self) -> CuttingPath:
        """Lead-in, one turn and lead-out."""
        origin = np.array(self.pose.position)
        plane = Plane(origin)
        if self.across_tool:
            plane = Plane.perpendicular_to(self.pose.tool_axis, origin)
        if self.lead_in is LeadIn.SPIRAL:
            return CuttingPath.around(self.curve, plane, lead=SPIRAL_LEAD, spiral=SPIRAL_START)
        return CuttingPath.around(self.curve, plane)


@dataclass(frozen=True, kw_only=True)
class CircleTask(CutTask):
    """A circle to be cut: where, how large, how fast."""

    radius: float = 0.005
    """Programmed [m]."""

    @property
    def curve(self) -> Circle:
        """The circle."""
        return Circle(self.radius)


@dataclass(frozen=True, kw_only=True)
class ContourTask(CutTask):
    """Any closed contour to be cut."""

    contour: ClosedCurve

    @property
    def curve(self) -> ClosedCurve:
        """The contour."""
        return self.contour
