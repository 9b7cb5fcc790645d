"""Path accuracy and path repeatability, after ISO 9283 section 8: how near, and how alike.

The standard drives a path n times and asks, at points along it, where each attained path crosses
the plane normal to the command path. Ours are points of any dimension d, of attained paths that
were registered on the commanded one before: the place of the whole contour is not judged.
"""

import numpy as np

from armside.arrays import Array


def crossings(commanded: Array, tangent: Array, attained: Array) -> Array:
    """Where one attained path crosses the planes normal to the commanded one, shape (M, d) [m].

    Between samples the attained path is straight. Of several crossings of a plane the nearest to
    its commanded point counts; without any, the row is NaN.

    Args:
        commanded: (M, d) [m], points on the commanded path.
        tangent: (M, d), unit vectors along it.
        attained: (K, d) [m], samples of one turn; the last is joined to the first.
    """
    found = np.full(commanded.shape, np.nan)
    step = np.roll(attained, -1, axis=0) - attained
    for i, (c, t) in enumerate(zip(commanded, tangent, strict=True)):
        before = (attained - c) @ t
        after = np.roll(before, -1)
        crossing = np.flatnonzero((before <= 0.0) & (after > 0.0))
        if not len(crossing):
            continue
        share = before[crossing] / (before[crossing] - after[crossing])
        point = attained[crossing] + share[:, None] * step[crossing]
        found[i] = point[np.argmin(np.linalg.norm(point - c, axis=1))]
    return found


def path_accuracy(commanded: Array, attained: Array) -> float:
    """AT_p [m]: largest distance of a barycentre from its commanded point.

    Args:
        commanded: (M, d) [m].
        attained: (n, M, d) [m], where each of n runs crossed the plane of each point.
    """
    _check(attained)
    return float(np.linalg.norm(attained.mean(axis=0) - commanded, axis=1).max())


def path_repeatability(attained: Array) -> float:
    """RT_p [m]: largest over the points of mean + 3 standard deviations of the distance of the n
    attained positions from their barycentre.

    Args:
        attained: (n, M, d) [m], n >= 2.
    """
    _check(attained)
    if len(attained) < 2:
        raise ValueError(f"path repeatability needs two runs or more, got {len(attained)}")
    distance = np.linalg.norm(attained - attained.mean(axis=0), axis=2)
    return float((distance.mean(axis=0) + 3.0 * distance.std(axis=0, ddof=1)).max())


def _check(attained: Array) -> None:
    if attained.ndim != 3:
        raise ValueError(f"attained must have shape (n, M, d), got {attained.shape}")
