"""Entities of a drawing that can be cut, and options of reading one."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from .chain import MM, Chain

LARGEST = 20.0
"""Size of a drawing from which its unit is doubted [m]. ESTIMATE"""
JOIN = 0.05 * MM
"""Largest distance between ends that are joined [m]."""


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


@dataclass(frozen=True)
class Drawn:
    """One entity of a drawing."""

    chain: Chain = field(repr=False)
    name: str
    """Type and handle, as in LINE #2F."""
    layer: str


@dataclass(frozen=True)
class Drawing:
    """Everything of a drawing that is to be cut, and notes of what is not."""

    entities: tuple[Drawn, ...]
    notes: tuple[str, ...] = ()


def check_size(drawing: Drawing) -> None:
    """Raise ValueError for a drawing of a size that no part has: its unit is in doubt."""
    points = np.vstack([entity.chain.points for entity in drawing.entities])
    size = float(np.ptp(points, axis=0).max())
    if not size <= LARGEST:
        raise ValueError(
            f"its unit is in doubt: it is {size / MM:g} mm large; say --units mm or --units inch"
        )
