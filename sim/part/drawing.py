"""Entities of a drawing that can be cut, joined end to end, and options of reading one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array, check_numbers

from .arcs import MM, Chain, joined, place

if TYPE_CHECKING:
    import shapely as shapely
else:

    class _Shapely:
        """Shapely, of the extra `parts`: imported where it is first used; help needs no extra."""

        def __getattr__(self, name: str) -> Any:
            return getattr(import_module("shapely"), name)

    shapely = _Shapely()

LARGEST = 20.0
"""Size of a drawing from which its unit is doubted [m]. ESTIMATE"""
JOIN = 0.05 * MM
"""Largest distance between ends that are joined [m]."""
NEAR = 1.0 * MM
"""Gap up to which two ends that are not joined were meant to meet [m]."""
SEEN = 1e-6
"""Gap above which its closing is noted [m]; below it is rounding."""
SHORTEST = 1e-6
"""Length from which an entity is not zero [m]."""


class Unit(Enum):
    """Unit of a drawing."""

    MILLIMETRE = "mm"
    INCH = "inch"

    @property
    def metres(self) -> float:
        return MM if self is Unit.MILLIMETRE else 25.4 * MM


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Options of reading a drawing."""

    layers: tuple[str, ...] = ()
    """Layers to cut; all that are visible if empty."""
    unit: Unit | None = None
    """Unit of the drawing in place of its own."""
    join: float = JOIN
    """Largest distance between ends that are joined [m]."""

    def __post_init__(self) -> None:
        check_numbers(self, "join")
        if not (np.isfinite(self.join) and self.join > 0.0):
            raise ValueError(f"the tolerance of joining must be > 0 m, got {self.join}")

    def chooses(self, layer: str, visible: bool = True) -> bool:
        """Whether a layer is cut; names of layers do not distinguish upper and lower case."""
        if self.layers:
            return layer.lower() in {name.lower() for name in self.layers}
        return visible

    def check_layers(self, existing: Sequence[str]) -> None:
        """Raise ValueError for a chosen layer that the drawing has not."""
        known = {name.lower() for name in existing}
        for name in self.layers:
            if name.lower() not in known:
                listed = ", ".join(sorted(existing)) or "none"
                raise ValueError(f"there is no layer {name!r}. Layers: {listed}")


class DrawnChain(NamedTuple):
    """One entity of a drawing, or several one after the other."""

    chain: Chain
    name: str
    """Type and handle, as in LINE #2F, of the first; and how many more there are."""
    layer: str


class Drawing(NamedTuple):
    """Everything of a drawing that is to be cut, and notes of what is not."""

    entities: tuple[DrawnChain, ...]
    notes: tuple[str, ...] = ()


def check_size(drawing: Drawing) -> None:
    """Raise ValueError for a drawing of a size that no part has: its unit is in doubt."""
    points = np.vstack([entity.chain.points for entity in drawing.entities])
    size = float(np.ptp(points, axis=0).max())
    if not size <= LARGEST:
        raise ValueError(
            f"its unit is in doubt: it is {size / MM:g} mm large; say --units mm or --units inch"
        )


def join(
    entities: tuple[DrawnChain, ...], tolerance: float
) -> tuple[list[DrawnChain], tuple[str, ...]]:
    """Chains of entities whose ends are at most `tolerance` [m] apart, and notes of the gaps.

    Raises ValueError for an entity of zero length, for more than two ends in one place, and for an
    end that misses another by less than a millimetre: each with its place.
    """
    for entity in entities:
        if entity.chain.length < SHORTEST:
            raise ValueError(f"{entity.name} has zero length at {place(entity.chain.points[0])}")
    found = [e for e in entities if e.chain.closed]
    loose = [e for e in entities if not e.chain.closed]
    if not loose:
        return found, ()
    ends = np.array([point for e in loose for point in (e.chain.points[0], e.chain.points[-1])])
    mate = _mates(ends, loose, tolerance)
    gap = np.where(mate < 0, 0.0, np.linalg.norm(ends - ends[mate], axis=1))
    notes = [
        f"a gap of {gap[i] / MM:.3g} mm at {place(ends[i])} is closed, {_between(loose, i, j)}"
        for i, j in sorted(enumerate(mate.tolist()), key=lambda pair: -gap[pair[0]])
        if i < j and gap[i] > SEEN
    ]
    met = np.where(mate[:, np.newaxis] < 0, ends, 0.5 * (ends + ends[mate]))
    for walk in _walks(mate):
        chains = []
        for end in walk:
            chain = loose[end // 2].chain
            chain = chain if end % 2 == 0 else chain.reversed
            points = chain.points.copy()
            points[0], points[-1] = met[end], met[end ^ 1]
            chains.append(Chain(points, chain.bulge))
        first, more = loose[walk[0] // 2], f" and {len(walk) - 1} more" if len(walk) > 1 else ""
        found.append(DrawnChain(joined(chains), f"{first.name}{more}", first.layer))
    return found, tuple(notes)


def _between(loose: list[DrawnChain], i: int, j: int) -> str:
    return f"between {loose[i // 2].name} and {loose[j // 2].name}"


def _mates(ends: Array, loose: list[DrawnChain], tolerance: float) -> NDArray[np.int64]:
    """Index of the end that meets each end, or -1. Ends 2 i and 2 i + 1 are those of entity i."""
    from scipy.spatial import KDTree

    mate = np.full(len(ends), -1)
    for i, j in sorted(KDTree(ends).query_pairs(tolerance)):
        if mate[i] >= 0 or mate[j] >= 0:
            names = sorted({loose[k // 2].name for k in (i, j, mate[i], mate[j]) if k >= 0})
            raise ValueError(
                f"more than two ends meet at {place(ends[i])}: those of {', '.join(names)}"
            )
        mate[i], mate[j] = j, i
    single = np.flatnonzero(mate < 0)
    if len(single) > 1:
        apart, nearest = map(np.asarray, KDTree(ends[single]).query(ends[single], k=2))
        worst = int(np.argmin(apart[:, 1]))
        i, j = int(single[worst]), int(single[nearest[worst, 1]])
        if apart[worst, 1] < NEAR:
            raise ValueError(
                f"the contour is open by {apart[worst, 1] / MM:.3g} mm at {place(ends[i])}, "
                f"{_between(loose, i, j)}"
            )
    return mate


def _walks(mate: NDArray[np.int64]) -> Iterator[list[int]]:
    """First ends of entities in order along each chain."""
    unused = set(range(len(mate) // 2))
    for first in [*np.flatnonzero(mate < 0).tolist(), *range(0, len(mate), 2)]:
        walk, end = list[int](), first
        while end >= 0 and end // 2 in unused:
            unused.remove(end // 2)
            walk.append(end)
            end = int(mate[end ^ 1])
        if walk:
            yield walk
