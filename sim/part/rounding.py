"""Corners of a contour rounded: short arcs that join smoothly on both sides."""

import numpy as np

from .biarc import biarc
from .chain import MM, Chain, joined, place

CORNER = 0.5 * MM
"""Radius with which sharp corners are cut [m]. ESTIMATE"""
SMOOTH = 1e-4
"""Largest angle between elements that join smoothly [rad]."""
BACK = np.radians(175.0)
"""Angle from which a contour turns back on itself [rad]."""
UNSEEN = 1e-6
"""Distance from the drawn corner up to which a larger radius is taken [m]."""


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
        return _between(chain, at, cut, [0.0], [chain.length])
    # From the middle of the arc at the first corner: turn the chain so that none is at its seam.
    start = float(at[0] + cut[0] + 0.5 * max(0.0, _free(chain, at, cut)))
    turned = rotated(chain, start)
    places = np.mod(at - start, chain.length)
    order = np.argsort(places)
    return _between(turned, places[order], cut[order], [0.0], [chain.length])


def rotated(chain: Chain, s: float) -> Chain:
    """A closed chain that starts at arc length s [m]."""
    s = float(np.mod(s, chain.length))
    if s < 1e-9 or chain.length - s < 1e-9:
        return chain
    return joined([chain.part(s, chain.length), chain.part(0.0, s)])


def _free(chain: Chain, at: np.ndarray, cut: np.ndarray) -> float:
    """Length between the arcs at the first two corners [m]."""
    following = at[1] - cut[1] if len(at) > 1 else at[0] + chain.length - cut[0]
    return float(following - at[0] - cut[0])


def _between(
    chain: Chain, at: np.ndarray, cut: np.ndarray, first: list[float], last: list[float]
) -> Chain:
    begins = np.concatenate([first, at + cut])
    ends = np.concatenate([at - cut, last])
    pieces: list[Chain] = []
    for i, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        if end - begin > 1e-9:
            pieces.append(chain.part(float(begin), float(end)))
        if i < len(at):
            pieces.append(_corner(chain, float(ends[i]), float(begins[i + 1])))
    whole = joined(pieces)
    if chain.closed:
        whole = Chain(np.vstack([whole.points[:-1], whole.points[:1]]), whole.bulge)
    return whole


def _corner(chain: Chain, before: float, after: float) -> Chain:
    points, heading = chain.point([before, after]), chain.direction([before, after])
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return biarc(points[0], along[0], points[1], along[1])
