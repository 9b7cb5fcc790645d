"""Calibration of a scanner by a grid of known pitch: scale, skew and wobble of its carriage."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from .image import ScanImage

SAME = 0.5e-3
"""Largest difference between the scanned areas of grid and sheet [m]."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Errors of a scanner, over the area that it scans.

    A point of the image at (x, y) is seen where A (x, y) + w(y) lies on the glass, about the middle
    of the area.
    """

    matrix: Array
    """(2, 2), A: scale in x and y, and skew; its lower left element is 0."""
    y: Array
    """(K,) [m], in the image, at which the wobble is known; between them it is a cubic spline."""
    wobble: Array
    """(K, 2) [m], w in x and y."""
    area: tuple[float, float]
    """Width and height [m] of the image."""
    residual: float
    """RMS [m] that is left of the grid."""
    scale: float = 1e-4
    """Standard deviation of the scale: that of the grid. ESTIMATE"""

    def check(self, image: ScanImage) -> None:
        """Raise ValueError for an image of another area: the wobble belongs to the place."""
        if max(abs(a - b) for a, b in zip(image.size, self.area, strict=True)) > SAME:
            given, own = (
                " x ".join(f"{1e3 * v:.1f}" for v in size) + " mm"
                for size in (image.size, self.area)
            )
            raise ValueError(f"it shows {given}, the calibration {own}: scan the same area")

    def corrected(self, points: Array) -> Array:
        """Points (N, 2) [m] of an image, where they lie on the glass."""
        from scipy.interpolate import CubicSpline

        middle = 0.5 * np.array(self.area)
        wobble = CubicSpline(self.y, self.wobble)(np.clip(points[:, 1], self.y[0], self.y[-1]))
        return middle + (points - middle) @ self.matrix.T + wobble
