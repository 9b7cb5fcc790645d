"""Entities joined end to end."""

from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array

from .chain import MM, Chain, joined, place
from .drawn import Drawn

NEAR = 1.0 * MM
"""Gap up to which two ends that are not joined were meant to meet [m]."""
SHORTEST = 1e-6
"""Length from which an entity is not zero [m]."""


@dataclass(frozen=True)
class Joined:
    """Entities one after the other, closed or open."""

    chain: Chain = field(repr=False)
    names: tuple[str, ...]
    layer: str

    @property
    def name(self) -> str:
        """Its first entity, and how many more there are."""
        more = len(self.names) - 1
        return self.names[0] + (f" and {more} more" if more else "")


def join(entities: tuple[Drawn, ...], tolerance: float) -> list[Joined]:
    """Chains of entities whose ends are at most `tolerance` [m] apart.

    Raises ValueError for an entity of zero length, for more than two ends in one place, and for an
    end that misses another by less than a millimetre: each with its place.
    """
    for entity in entities:
        if entity.chain.length < SHORTEST:
            raise ValueError(f"{entity.name} has zero length at {place(entity.chain.points[0])}")
    found = [Joined(e.chain, (e.name,), e.layer) for e in entities if e.chain.closed]
    loose = [e for e in entities if not e.chain.closed]
    if not loose:
        return found
    ends = np.array([point for e in loose for point in (e.chain.points[0], e.chain.points[-1])])
    mate = _mates(ends, loose, tolerance)
    walks = _walks(mate)
    found += [_joined(walk, closed, loose, ends, mate) for walk, closed in walks]
    return found


def _mates(ends: Array, loose: list[Drawn], tolerance: float) -> list[int]:
    """Index of the end that meets each end, or -1. Ends 2 i and 2 i + 1 are those of entity i."""
    from scipy.spatial import KDTree

    tree = KDTree(ends)
    mate = [-1] * len(ends)
    for i, j in sorted(tree.query_pairs(tolerance)):
        if mate[i] >= 0 or mate[j] >= 0:
            names = sorted({loose[k // 2].name for k in (i, j, mate[i], mate[j]) if k >= 0})
            raise ValueError(
                f"more than two ends meet at {place(ends[i])}: those of {', '.join(names)}"
            )
        mate[i], mate[j] = j, i
    single = np.array([k for k, other in enumerate(mate) if other < 0], dtype=int)
    if len(single) > 1:
        apart, nearest = map(np.asarray, KDTree(ends[single]).query(ends[single], k=2))
        worst = int(np.argmin(apart[:, 1]))
        i, j = int(single[worst]), int(single[nearest[worst, 1]])
        if apart[worst, 1] < NEAR:
            raise ValueError(
                f"the contour is open by {apart[worst, 1] / MM:.3g} mm at {place(ends[i])}, "
                f"between {loose[i // 2].name} and {loose[j // 2].name}"
            )
    return mate


def _walks(mate: list[int]) -> list[tuple[list[int], bool]]:
    """First ends of entities in order along each chain, and whether it is closed."""
    unused = set(range(len(mate) // 2))
    single = [k for k, other in enumerate(mate) if other < 0]
    walks = []
    for first in [*single, *range(0, len(mate), 2)]:
        if first // 2 not in unused:
            continue
        walk, end = [], first
        while end >= 0 and end // 2 in unused:
            unused.remove(end // 2)
            walk.append(end)
            end = mate[end ^ 1]
        walks.append((walk, end >= 0))
    return walks


def _joined(
    walk: list[int], closed: bool, loose: list[Drawn], ends: Array, mate: list[int]
) -> Joined:
    chains = []
    for end in walk:
        chain = loose[end // 2].chain
        chain = chain if end % 2 == 0 else chain.reversed
        points = chain.points.copy()
        points[0], points[-1] = _met(end, ends, mate), _met(end ^ 1, ends, mate)
        chains.append(Chain(points, chain.bulge))
    whole = joined(chains)
    assert whole.closed or not closed
    names = tuple(loose[end // 2].name for end in walk)
    return Joined(whole, names, loose[walk[0] // 2].layer)


def _met(end: int, ends: Array, mate: list[int]) -> Array:
    """Place of an end: halfway to the one that it meets."""
    if mate[end] < 0:
        return ends[end]
    return 0.5 * (ends[min(end, mate[end])] + ends[max(end, mate[end])])
