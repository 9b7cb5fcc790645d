"""Path accuracy and path repeatability after ISO 9283 section 8.

A path is driven n times. At points along the commanded path each attained path is intersected with
the plane normal to the commanded one. Points have any dimension d; attained paths are registered
on the commanded one before, so the position of the whole contour is not judged.
"""

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_real, records


@records("commanded", "tangent")
@records("attained")
def crossings(commanded: Array, tangent: Array, attained: Array) -> Array:
    """Intersections of one attained path with the normal planes of the commanded one, (M, d) [m].

    The attained path is interpolated linearly. Of several intersections with a plane the nearest
    to its commanded point is returned; without any, the row is NaN.

    Args:
        commanded: (M, d) [m], points on the commanded path.
        tangent: (M, d), unit vectors along it.
        attained: (K, d) [m], samples of one revolution; the last is joined to the first.
    """
    if attained.shape[1] != commanded.shape[1]:
        given = f"got {attained.shape[1]} and {commanded.shape[1]}"
        raise ValueError(f"attained and commanded must have one dimension, {given}")
    found = np.full(commanded.shape, np.nan)
    step = np.roll(attained, -1, axis=0) - attained
    for i, (c, t) in enumerate(zip(commanded, tangent, strict=True)):
        before = (attained - c) @ t
        after = np.roll(before, -1)
        crossing = np.flatnonzero((before <= 0.0) & (after > 0.0))
        if not len(crossing):
            continue
        fraction = before[crossing] / (before[crossing] - after[crossing])
        point = attained[crossing] + fraction[:, None] * step[crossing]
        found[i] = point[np.argmin(np.linalg.norm(point - c, axis=1))]
    return found


def path_accuracy(commanded: Array, attained: Array) -> float:
    """AT_p [m]: largest distance of a barycentre from its commanded point, (M, d) [m].

    attained: (n, M, d) [m], intersections of n runs with the plane of each point.
    """
    attained, commanded = _as_runs(attained), as_real(commanded, "commanded")
    if attained.shape[1:] != commanded.shape:
        text = f"{commanded.shape} as commanded, got {attained.shape[1:]}"
        raise ValueError(f"each run of attained must have the shape {text}")
    return float(np.linalg.norm(attained.mean(axis=0) - commanded, axis=1).max())


def path_repeatability(attained: Array) -> float:
    """RT_p [m]: largest over the points of mean + 3 standard deviations of the distance of the n
    attained positions, (n, M, d) [m], n >= 2, from their barycentre.
    """
    attained = _as_runs(attained)
    if len(attained) < 2:
        raise ValueError(f"path repeatability needs two runs or more, got {len(attained)}")
    distance = np.linalg.norm(attained - attained.mean(axis=0), axis=2)
    return float((distance.mean(axis=0) + 3.0 * distance.std(axis=0, ddof=1)).max())


def _as_runs(attained: ArrayLike) -> Array:
    runs = as_real(attained, "attained")
    if runs.ndim != 3 or 0 in runs.shape:
        raise ValueError(f"attained must have shape (n, M, d), got {runs.shape}")
    return runs
