"""What a closed contour in a plane is."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class ClosedCurve(Protocol):
    """A closed curve in a plane, traversed counter-clockwise; s is taken modulo `length`."""

    @property
    def length(self) -> float:
        """Once around [m]."""
        ...

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature [m]."""
        ...

    def point(self, s: ArrayLike) -> Array:
        """Shape (..., 2) [m]."""
        ...

    def tangent(self, s: ArrayLike) -> Array:
        """Unit vector along increasing s, shape (..., 2)."""
        ...

    def nearest(self, p: Array) -> Array:
        """Arc length of the point of the curve that is nearest to each of p (N, 2)."""
        ...
