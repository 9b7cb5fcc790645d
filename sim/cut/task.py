"""Cutting tasks: a contour, its pose, lead-in and speed."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..cell import ToolPose
from .contour import Circle, ClosedCurve
from .path import CuttingPath, Plane
from .timing import PathLimits

SPIRAL_START = 0.6
"""Scale of the contour on which a spiral starts."""
SPIRAL_LEAD = 0.25
"""Length of a spiral over that of the contour: its smallest radius is 0.4 of a circle's."""


class LeadIn(Enum):
    """Kind of the lead-in."""

    ARC = "arc"
    """Along the contour itself."""
    SPIRAL = "spiral"
    """Outwards from inside it."""


@dataclass(frozen=True, kw_only=True)
class CutTask(ABC):
    """Contour to be cut."""

    pose: ToolPose
    """Centre of the contour, and constant orientation of the tool."""
    speed: float = 0.040
    """Programmed [m/s]."""
    across_tool: bool = False
    """True for the plane perpendicular to the tool axis, False for the base x-y plane."""
    lead_in: LeadIn = LeadIn.ARC
    limits: PathLimits | None = None
    """Path limits of the controller; its defaults if None."""

    @property
    @abstractmethod
    def curve(self) -> ClosedCurve:
        """Contour around the origin of its plane."""

    @property
    def path(self) -> CuttingPath:
        """Path with lead-in, contour and lead-out."""
        origin = np.array(self.pose.position)
        plane = Plane(origin)
        if self.across_tool:
            plane = Plane.perpendicular_to(self.pose.tool_axis, origin)
        if self.lead_in is LeadIn.SPIRAL:
            return CuttingPath.around(self.curve, plane, lead=SPIRAL_LEAD, spiral=SPIRAL_START)
        return CuttingPath.around(self.curve, plane)


@dataclass(frozen=True, kw_only=True)
class CircleTask(CutTask):
    """Circle to be cut."""

    radius: float = 0.005
    """Programmed [m]."""

    @property
    def curve(self) -> Circle:
        """The circle."""
        return Circle(self.radius)


@dataclass(frozen=True, kw_only=True)
class ContourTask(CutTask):
    """Closed contour of any shape to be cut."""

    contour: ClosedCurve

    @property
    def curve(self) -> ClosedCurve:
        """The contour."""
        return self.contour
