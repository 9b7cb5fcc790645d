"""Path of the beam's centre over a contour: corners rounded, half a beam aside, with leads."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from .arcs import MM, Chain, arc, biarc, joined, place
from .drawing import shapely
from .part import SAGITTA

CORNER = 0.5 * MM
"""Radius with which sharp corners are cut [m]. ESTIMATE"""
SMOOTH = 1e-4
"""Largest angle between elements that join smoothly [rad]."""
BACK = np.radians(175.0)
"""Angle from which a contour turns back on itself [rad]."""
UNSEEN = 1e-6
"""Distance from the drawn corner up to which a larger radius is taken [m]."""
ROUNDING = 1e-7
"""Relative length by which a width of exactly the beam still passes."""
RADIUS = 2.0 * MM
"""Radius of a lead where there is room [m]. ESTIMATE"""
NEAR = 3e-6
"""Overlap of a beam and a contour that their polygons may show by themselves [m]."""
SMALLEST = 0.05 * MM
"""Radius of a lead below which there is none [m]."""


def smooth(chain: Chain, corner: float = CORNER) -> Chain:
    """The chain with arcs of radius `corner` [m] in place of its corners.

    An arc is smaller where the elements beside it are too short, and larger at a slight corner: as
    large as stays within 1 um of it. An open chain keeps its ends.

    Raises ValueError where the chain turns back on itself.
    """
    kinks = np.abs(chain.kinks)
    sharp = np.flatnonzero(kinks > SMOOTH)
    if not len(sharp):
        return chain
    if kinks.max() > BACK:
        raise ValueError(f"it turns back on itself at {place(chain.points[kinks.argmax()])}")
    at, half = chain.ends[sharp], kinks[sharp] / 2.0
    radius = np.maximum(corner, UNSEEN / (1.0 / np.cos(half) - 1.0))
    shorter = np.minimum(chain.lengths, np.roll(chain.lengths, 1))[sharp]
    cut = np.minimum(radius * np.tan(half), 0.49 * shorter)
    if not chain.closed:
        return _between(chain, at, cut)
    # From the middle of the first side: turn the chain so that no corner is at its seam.
    following = at[1] - cut[1] if len(at) > 1 else at[0] + chain.length - cut[0]
    start = float(at[0] + cut[0] + 0.5 * max(0.0, following - at[0] - cut[0]))
    places = np.mod(at - start, chain.length)
    order = np.argsort(places)
    return _between(rotated(chain, start), places[order], cut[order])


def rotated(chain: Chain, s: float) -> Chain:
    """A closed chain that starts at arc length s [m]."""
    s = float(np.mod(s, chain.length))
    if s < 1e-9 or chain.length - s < 1e-9:
        return chain
    return joined([chain.part(s, chain.length), chain.part(0.0, s)])


def _between(chain: Chain, at: Array, cut: Array) -> Chain:
    """The chain with an arc from `cut` [m] before to as far behind each of the places `at` [m]."""
    ends = np.concatenate([[0.0], np.column_stack([at - cut, at + cut]).ravel(), [chain.length]])
    points, heading = chain.point(ends), chain.direction(ends)
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    pieces: list[Chain] = []
    for i in range(len(ends) - 1):
        if i % 2:
            pieces.append(biarc(points[i], along[i], points[i + 1], along[i + 1]))
        elif ends[i + 1] - ends[i] > 1e-9:
            pieces.append(chain.part(float(ends[i]), float(ends[i + 1])))
    whole = joined(pieces)
    return whole.ending_at_start() if chain.closed else whole


def compensated(chain: Chain, half: float, outwards: bool) -> Chain:
    """The smooth, counter-clockwise chain moved by `half` [m] outwards or inwards, exactly.

    Raises ValueError where an arc or the width between two sides is too small for the beam.
    """
    side = half if outwards else -half
    tight = 1.0 + side * chain.curvature
    if tight.min() <= ROUNDING:
        i = int(tight.argmin())
        middle = chain.point(chain.ends[i] + 0.5 * chain.lengths[i])
        radius = 1.0 / abs(chain.curvature[i])
        raise ValueError(
            f"the beam of {2 * half / MM:g} mm is too wide for the radius of "
            f"{radius / MM:.3g} mm at {place(middle)}"
        )
    normal = np.stack([np.sin(chain.heading), -np.cos(chain.heading)], axis=1)
    moved = chain.points[:-1] + side * normal
    path = Chain(np.vstack([moved, moved[:1]]), chain.bulge)
    points = path.polygon(SAGITTA)
    apart = shapely.distance(shapely.points(points), shapely.LinearRing(chain.polygon(SAGITTA)))
    if apart.min() < half - 4 * SAGITTA:
        at = place(points[int(apart.argmin())])
        raise ValueError(f"the beam of {2 * half / MM:g} mm is wider than the slot at {at}")
    return path


class Led(NamedTuple):
    """Path of one contour: lead-in, one turn, lead-out."""

    path: Chain
    lead: float
    """Length of each lead [m]."""


def led(path: Chain, inwards: bool, half: float, others: "shapely.STRtree", own: int) -> Led:
    """Leads at the middle of the longest element, in the scrap.

    inwards: the scrap is inside. others: contours that a beam of half width `half` [m] must not
    touch on the leads, but for that of index `own`. A lead is shortened until it fits; where none
    fits there is none.
    """
    longest = int(np.argmax(path.lengths))
    turned = rotated(path, float(path.ends[longest] + 0.5 * path.lengths[longest]))
    start, ring = shapely.Point(turned.points[0]), shapely.Polygon(path.polygon())
    radius = RADIUS
    while radius > SMALLEST:
        leads = _quarters(turned, radius, inwards)
        lines = [shapely.LineString(lead.polygon()) for lead in leads]
        # Where they touch the path they are tangent to it, on polygons within their sagitta.
        free = [line.difference(start.buffer(0.3 * leads[0].length)) for line in lines]
        in_scrap = all(ring.contains(line) if inwards else ring.disjoint(line) for line in free)
        if in_scrap and not (meets(lines, half, others)[1] != own).any():
            return Led(joined([leads[0], turned, leads[1]]), leads[0].length)
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
    entry.points[-1] = leave.points[0] = start
    return entry, leave


def meets(
    lines: list["shapely.LineString"], half: float, contours: "shapely.STRtree"
) -> NDArray[np.int64]:
    """(2, N), which line of the beam's centre comes nearer than `half` [m] to which contour."""
    return contours.query(lines, predicate="dwithin", distance=half - NEAR)
