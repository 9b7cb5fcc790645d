"""Order of cuts: inner contours before those around them, with short rapid moves.

Contours of one depth are visited from the nearest to the next (nearest neighbour), then pairs of
moves are exchanged (2-opt) and single contours moved (or-opt) while that shortens the way.
"""

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

PASSES = 50
"""Most sweeps of exchanges over all contours."""
LITTLE = 1e-3
"""Relative shortening of all rapid moves by a sweep below which it was the last."""
GAIN = 1e-9
"""Shortening [m] below which an exchange is none."""


def order(entry: Array, leave: Array, depth: list[int], start: Array) -> list[int]:
    """Indices in the order of the cuts.

    entry, leave: (M, 2) [m], where each cut begins and ends; depth: contours around each; start:
    (2,) [m], where the tool is before.
    """
    found: list[int] = []
    at = start
    for level in sorted(set(depth), reverse=True):
        members = np.flatnonzero(np.array(depth) == level)
        # D[i, j]: from the end of i to the begin of j; the last row is the start.
        ends = np.vstack([leave[members], at])
        D = np.linalg.norm(ends[:, np.newaxis] - entry[members], axis=2)
        found += members[_improved(_nearest(D), D)].tolist()
        at = leave[found[-1]]
    return found


def _nearest(D: Array) -> NDArray[np.int64]:
    n = D.shape[1]
    tour, free, at = np.zeros(n, dtype=np.int64), np.ones(n, dtype=bool), -1
    for k in range(n):
        tour[k] = at = int(np.argmin(np.where(free, D[at], np.inf)))
        free[at] = False
    return tour


def _improved(tour: NDArray[np.int64], D: Array) -> NDArray[np.int64]:
    for _ in range(PASSES):
        before = _length(tour, D)
        tour = _shift(_exchange(tour, D), D)
        if _length(tour, D) > before * (1.0 - LITTLE) - GAIN:
            break
    return tour


def _length(tour: NDArray[np.int64], D: Array) -> float:
    return float(D[np.concatenate([[-1], tour[:-1]]), tour].sum())


def _exchange(tour: NDArray[np.int64], D: Array) -> NDArray[np.int64]:
    """Reverse stretches of the tour; moves inside a stretch change their direction as well."""
    for i in range(len(tour) - 1):
        before = np.concatenate([[-1], tour])
        onward, backward = D[tour[:-1], tour[1:]], D[tour[1:], tour[:-1]]
        turned = np.concatenate([[0.0], np.cumsum(backward[i:] - onward[i:])])
        j = np.arange(i, len(tour))
        after = np.concatenate([tour[1:], [0]])
        open_end = j == len(tour) - 1
        old = D[before[i], tour[i]] + np.where(open_end, 0.0, D[tour[j], after[j]])
        new = D[before[i], tour[j]] + np.where(open_end, 0.0, D[tour[i], after[j]])
        change = new - old + turned
        best = int(np.argmin(change))
        if change[best] < -GAIN:
            tour = np.concatenate([tour[:i], tour[i : i + best + 1][::-1], tour[i + best + 1 :]])
    return tour


def _shift(tour: NDArray[np.int64], D: Array) -> NDArray[np.int64]:
    """Put stretches of one to three contours elsewhere."""
    for size, i in [(n, i) for n in (1, 2, 3) for i in range(len(tour) - n)]:
        stretch, rest = tour[i : i + size], np.delete(tour, slice(i, i + size))
        before, after = np.concatenate([[-1], rest]), np.concatenate([rest, [-1]])
        closing = np.where(np.arange(len(after)) == len(rest), 0.0, 1.0)
        gain = D[before, stretch[0]] + closing * (D[stretch[-1], after] - D[before, after])
        best = int(np.argmin(gain))
        if gain[best] < gain[i] - GAIN:
            tour = np.concatenate([rest[:best], stretch, rest[best:]])
    return tour
