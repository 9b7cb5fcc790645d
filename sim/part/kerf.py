"""Compensation of the kerf: the beam's centre runs half its diameter beside the contour."""

import numpy as np

from .chain import MM, Chain, place
from .geometry import shapely
from .part import SAGITTA

ROUNDING = 1e-7
"""Relative length by which a width of exactly the beam still passes."""


def compensated(chain: Chain, half: float, outwards: bool) -> Chain:
    """The smooth, counter-clockwise chain moved by `half` [m] outwards or inwards, exactly.

    Lines stay lines and arcs stay arcs of the same angle.

    Raises ValueError where an arc or the width between two sides is too small for the beam.
    """
    side = half if outwards else -half
    tight = 1.0 + side * chain.curvature
    if (worst := tight.min()) <= ROUNDING:
        i = int(tight.argmin())
        middle = chain.point(chain.ends[i] + 0.5 * chain.lengths[i])
        radius = 1.0 / abs(chain.curvature[i])
        raise ValueError(
            f"the beam of {2 * half / MM:g} mm is too wide for the radius of "
            f"{radius / MM:.3g} mm at {place(middle)}"
        )
    assert worst > 0.0
    normal = np.stack([np.sin(chain.heading), -np.cos(chain.heading)], axis=1)
    moved = chain.points[:-1] + side * normal
    path = Chain(np.vstack([moved, moved[:1]]), chain.bulge)
    _check_width(chain, path, half)
    return path


def _check_width(chain: Chain, path: Chain, half: float) -> None:
    """Raise ValueError where the path comes nearer to the contour than half of the beam."""
    drawn = shapely.LinearRing(chain.polygon(SAGITTA))
    points = path.polygon(SAGITTA)
    apart = shapely.distance(shapely.points(points), drawn)
    if apart.min() < half - 4 * SAGITTA:
        at = place(points[int(apart.argmin())])
        raise ValueError(f"the beam of {2 * half / MM:g} mm is wider than the slot at {at}")
