"""Lead-in and lead-out of a contour: quarter circles on the side of the scrap."""

from dataclasses import dataclass, field

import numpy as np

from .chain import MM, Chain, arc, joined
from .geometry import shapely
from .rounding import rotated

RADIUS = 2.0 * MM
"""Radius of a lead where there is room [m]. ESTIMATE"""
SMALLEST = 0.05 * MM
"""Radius of a lead below which there is none [m]."""


@dataclass(frozen=True)
class Led:
    """Path of one contour, with its leads."""

    path: Chain = field(repr=False)
    """Lead-in, one turn, lead-out."""
    lead: float
    """Length of each lead [m]."""


def led(path: Chain, inwards: bool, obstacles: "shapely.STRtree | None" = None) -> Led:
    """Leads at the middle of the longest element, in the scrap.

    inwards: the scrap is inside. obstacles: contours that the leads must not touch. A lead is
    shortened until it fits; where none fits there is none.
    """
    longest = int(np.argmax(path.lengths))
    turned = rotated(path, float(path.ends[longest] + 0.5 * path.lengths[longest]))
    ring = shapely.Polygon(path.polygon())
    radius = RADIUS
    while radius > SMALLEST:
        entry, leave = _quarters(turned, radius, inwards)
        if _fits([entry, leave], ring, inwards, obstacles):
            return Led(joined([entry, turned, leave]), entry.length)
        radius *= 0.7
    return Led(turned, 0.0)


def _quarters(path: Chain, radius: float, inwards: bool) -> tuple[Chain, Chain]:
    """Quarter circles that end and begin where the path starts, tangent to it."""
    start, heading = path.points[0], float(path.heading[0])
    side = 1.0 if inwards else -1.0  # the inside is to the left
    centre = start + side * radius * np.array([-np.sin(heading), np.cos(heading)])
    at = heading - side * np.pi / 2.0
    entry = arc(centre, radius, at - side * np.pi / 2.0, side * np.pi / 2.0)
    leave = arc(centre, radius, at, side * np.pi / 2.0)
    ends = (np.vstack([entry.points[:-1], start]), np.vstack([start, leave.points[1:]]))
    return Chain(ends[0], entry.bulge), Chain(ends[1], leave.bulge)


def _fits(
    leads: list[Chain], ring: "shapely.Polygon", inwards: bool, obstacles: "shapely.STRtree | None"
) -> bool:
    lines = [shapely.LineString(lead.polygon()) for lead in leads]
    # Where they touch the path they are tangent to it, on polygons within their sagitta.
    free = [
        line.difference(shapely.Point(lead.points[k]).buffer(0.3 * lead.length))
        for line, lead, k in zip(lines, leads, (-1, 0), strict=True)
    ]
    inside = [ring.contains(line) if inwards else ring.disjoint(line) for line in free]
    if not all(inside):
        return False
    return obstacles is None or not len(obstacles.query(lines, predicate="intersects")[0])
