"""Specification of a cut: contour, place, speed, and the robot individual that makes it."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..motion.contour import Circle, ClosedCurve
from ..motion.path import CuttingPath, Plane
from .setup import Setup

SPIRAL_START = 0.6  # Fraction of its size at which a contour's spiral starts
SPIRAL_LEAD = 0.25  # Length of a spiral in turns: its bends have 0.4 of a circle's radius


class LeadIn(Enum):
    """Path from the start of the cut to the contour."""

    ARC = "arc"
    """Along the contour itself."""
    SPIRAL = "spiral"
    """Outwards from inside it."""


@dataclass(frozen=True, kw_only=True)
class Cut(Setup):
    """One cut by one robot individual. SI units."""

    contour: ClosedCurve | None = None
    """Contour around the origin of its plane; a circle of `radius` if None."""
    radius: float = 0.005
    """Programmed radius of the circle [m]."""
    speed: float = 0.040
    """Programmed speed along the path [m/s]."""
    across_tool: bool = False
    """In the plane perpendicular to the tool axis instead of the base x-y plane."""
    lead_in: LeadIn = LeadIn.ARC

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

    @property
    def plane(self) -> Plane:
        """Plane of the contour, its origin at the pose."""
        return plane_at(self, self.across_tool)


def plane_at(setup: Setup, across_tool: bool) -> Plane:
    """Plane through the pose: parallel to the base x-y plane, or across the tool's axis."""
    origin = np.array(setup.tool_pose.position)
    if across_tool:
        return Plane.perpendicular_to(setup.tool_pose.tool_axis, origin)
    return Plane(origin)
