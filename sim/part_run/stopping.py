"""Learning of a part that ends contour by contour, as each has converged."""

from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.laws.wrappers import BySegment, SegmentMemory

from ..laser.measures import Output
from ..part.motion import PartMotion

SHORTEST_BLEND = 0.1
"""Time in which one contour's correction becomes that of the next, at least [s]. ESTIMATE"""


def by_contour(output: Output, motion: PartMotion, least: float) -> BySegment:
    """The law of an output, for each contour until it has converged.

    least: fraction by which an update must lower the error of a contour to count as progress.
    """
    ends = np.array([cut.contour_time for cut in motion.cuts])
    judged = np.searchsorted(motion.time, ends)
    return BySegment(
        law=output.law,
        weight=weights(motion),
        judged=tuple((int(first), int(last)) for first, last in judged),
        size_of=output.size,
        least=least,
    )


def weights(motion: PartMotion) -> Array:
    """(N, M), of each contour's correction: its cut, and what follows until the next pierces."""
    begun = np.ones((motion.n_samples, len(motion.cuts) + 1))
    begun[:, -1] = 0.0
    for i, cut in enumerate(motion.cuts[1:], start=1):
        before = max((leg.end for leg in motion.legs if leg.end <= cut.start), default=cut.start)
        width = max(cut.start - before, SHORTEST_BLEND)
        x = np.clip((motion.time - cut.start) / width + 1.0, 0.0, 1.0)
        begun[:, i] = 0.5 - 0.5 * np.cos(np.pi * x)
    return begun[:, :-1] - begun[:, 1:]


def held(memory: Any, n: int) -> tuple[bool, ...]:
    """(n,) whether each contour has converged and keeps its correction."""
    if isinstance(memory, SegmentMemory):
        return tuple(bool(one) for one in memory.held)
    return (False,) * n
