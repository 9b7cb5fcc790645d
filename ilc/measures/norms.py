"""Error measures of the motor side and of a circle on the arm side.

Thesis 9.3. `normalise` turns the raw measures into (9.5), (9.8) and (9.9).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..records import as_real, as_samples, records


@records("error", gate=as_samples)
def two_norm(error: Array) -> Array:
    """sqrt(sum e^2) over the record of each column: shape (N, n) to (n,)."""
    # Scaled by the peak, so that a diverging record neither overflows nor warns.
    peak = inf_norm(error)
    scale = np.where((peak > 0.0) & np.isfinite(peak), peak, 1.0)
    return scale * np.sqrt(np.square(error / scale).sum(axis=0))


@records("error", gate=as_samples)
def inf_norm(error: Array) -> Array:
    """max |e| over the record of each column: shape (N, n) to (n,)."""
    return np.max(np.abs(error), axis=0)


def normalise(measure: ArrayLike, without_learning: ArrayLike) -> Array:
    """Measure divided by the largest of its values at k = 0. Thesis (9.5), (9.8), (9.9).

    measure: any shape. without_learning: the same measure at k = 0 for all motors (9.5) and
    experiments (9.5), (9.8), (9.9) that are compared, any shape. Raises ValueError if it is zero.
    """
    measure = as_real(measure, "measure")
    largest = np.max(as_real(without_learning, "without_learning"))
    if not (np.isfinite(largest) and largest > 0.0):
        raise ValueError(f"the largest error without learning must be > 0, got {largest}")
    return measure / largest


@records("first", "second")
def repeatability(first: Array, second: Array, best_error: float) -> Array:
    """||y_1 - y_2||_inf of each column over the smallest error reached with ILC. Thesis (9.10).

    first, second: outputs of two identical experiments at the same iteration, shape (N, n).
    best_error: min over iterations, motors and experiments of ||e||_inf.
    """
    if not best_error > 0.0:
        raise ValueError(f"best_error must be > 0, got {best_error}")
    return inf_norm(first - second) / best_error


@dataclass(frozen=True)
class Circle:
    """Circle in space, centre and radius in [m], and the measured points in its own plane."""

    centre: Array
    normal: Array
    radius: float
    in_plane: Array
    """(M, 2) [m], the points relative to the centre, along two axes of the plane."""

    @property
    def radii(self) -> Array:
        """(M,) [m], distance of each point from the centre, within the plane: r_meas of (9.6)."""
        return np.hypot(self.in_plane[:, 0], self.in_plane[:, 1])


def fit_circle(points: Array, normal: ArrayLike | None = None) -> Circle:
    """Circle with the least sum of squared radial distances to points, shape (M, 3) [m].

    The plane is the best-fit plane, or the one with the given normal. The points should cover
    one full revolution evenly: otherwise the centre moves to where they are dense.
    """
    points = as_real(points, "points")
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 3:
        raise ValueError(f"points must have shape (M, 3) with M >= 3, got {points.shape}")
    if not np.isfinite(points).all():
        missing = int((~np.isfinite(points).all(axis=1)).sum())
        raise ValueError(f"points must be finite, {missing} of {len(points)} are not")
    mean = points.mean(axis=0)
    axes = _plane_axes(points - mean, normal)
    flat = (points - mean) @ axes[:2].T
    centre = circle_centre(flat)
    in_plane = flat - centre
    radius = float(np.hypot(*in_plane.T).mean())
    return Circle(mean + centre @ axes[:2], axes[2], radius, in_plane)


@records("points")
def circle_centre(points: Array) -> Array:
    """Centre (2,) of the circle in a plane with the least sum of squared radial distances.

    points: (M, 2) [m], finite. Raises ValueError for points that lie on one line, or nearer to one
    than to any circle.
    """
    from .circle import least_squares  # imported here: compiled, and most measures do without

    origin = points.mean(axis=0)
    centre, found = least_squares(points - origin)
    if not found:
        raise ValueError("points must not lie on one line")
    return origin + centre


def circle_rms(radii: Array, r_ref: float) -> float:
    """Root mean square of r_ref - r_meas. Thesis (9.6); r_ref is the programmed radius [m]."""
    return float(np.sqrt(np.mean((r_ref - _as_radii(radii)) ** 2)))


def circle_maxdev(radii: Array, r_ref: float) -> float:
    """Largest |r_ref - r_meas|. Thesis (9.7); r_ref is the programmed radius [m]."""
    return float(np.max(np.abs(r_ref - _as_radii(radii))))


def circle_ripple(radii: Array, turn_time: float, low: float, high: float) -> float:
    """RMS of the radius between two frequencies [Hz], radii sampled evenly over one revolution.

    turn_time: duration of the revolution [s]; its harmonics in [low, high] count.
    """
    radii = _as_radii(radii)
    n = len(radii)
    power = np.square(np.abs(np.fft.rfft(radii - radii.mean()) / n))
    power[1 : (n + 1) // 2] *= 2.0  # both halves of the spectrum, the Nyquist frequency once
    frequency = np.arange(len(power)) / turn_time
    return float(np.sqrt(power[(frequency >= low) & (frequency <= high)].sum()))


def _as_radii(radii: ArrayLike) -> Array:
    values = as_real(radii, "radii")
    if values.size == 0 or not np.isfinite(values).all():
        raise ValueError("radii must be finite, and one at least")
    return values


def _plane_axes(centred: Array, normal: ArrayLike | None) -> Array:
    """Rows: two unit vectors in the plane and its normal, right-handed."""
    if normal is None:
        axes: Array = np.linalg.svd(centred, full_matrices=False)[2]
        e1, n = axes[0], axes[2]
    else:
        n = np.asarray(normal, dtype=np.float64)
        if n.shape != (3,) or not np.linalg.norm(n) > 0.0:
            raise ValueError(f"normal must be a vector of length > 0 in space, got {normal}")
        n = n / np.linalg.norm(n)
        e1 = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        e1 = e1 / np.linalg.norm(e1)
    return np.array([e1, np.cross(n, e1), n], dtype=np.float64)
