"""Contours of the episodes: one, or drawn from several shapes and a range of radii."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..motion.contour import RADII

SMALLEST, LARGEST = 0.001, 0.1
"""[m], of a radius that may be asked for."""


@dataclass(frozen=True)
class Shapes:
    """Shapes of an env and their radius, as `armside.sim.motion.contour.contour_of` has it."""

    names: tuple[str, ...] = ("circle",)
    radius: tuple[float, float] | None = None
    """Smallest and largest [m]; that of each shape's default if None."""

    @property
    def are_drawn(self) -> bool:
        """Contours differ between episodes."""
        low, high = self.radius or (0.0, 0.0)
        return len(self.names) > 1 or low < high

    def draw(self, rng: np.random.Generator) -> tuple[str, float | None]:
        """Shape and radius [m], None for the shape's default; draws nothing that is fixed."""
        name = self.names[0 if len(self.names) == 1 else int(rng.integers(len(self.names)))]
        if self.radius is None:
            return name, None
        low, high = self.radius
        return name, low if low == high else float(rng.uniform(low, high))


def shapes_of(shape: Any, radius: Any) -> Shapes:
    """Shapes of one name or several, and a radius [m] or a range of it.

    Raises ValueError for an unknown shape, or a radius out of range.
    """
    several = isinstance(shape, Sequence) and not isinstance(shape, str)
    names = tuple(check_shape(name) for name in (shape if several else (shape,)))
    if not names or len(set(names)) < len(names):
        raise ValueError(f"shape must be one or several different ones, got {shape!r}")
    if radius is None:
        return Shapes(names)
    ends = tuple(radius) if isinstance(radius, Sequence | np.ndarray) else (radius, radius)
    if len(ends) != 2:
        raise ValueError(f"radius must be a number or a range of two, got {radius!r}")
    low, high = (check_radius(end) for end in ends)
    if low > high:
        raise ValueError(f"radius must be a range from low to high, got {radius!r}")
    return Shapes(names, (low, high))


def check_shape(value: Any) -> str:
    """A known shape. Raises ValueError for any other."""
    if not isinstance(value, str) or value not in RADII:
        raise ValueError(f"Unknown shape {value!r}. It can be: {', '.join(RADII)}")
    return value


def check_radius(value: Any) -> float:
    """A radius [m]. Raises ValueError for what is no number in range."""
    numbers = int | float | np.integer | np.floating
    number = isinstance(value, numbers) and not isinstance(value, bool)
    if not (number and SMALLEST <= value <= LARGEST):
        limits = f"from {SMALLEST:g} to {LARGEST:g} m"
        raise ValueError(f"radius must be a number {limits}, got {value!r}")
    return float(value)
