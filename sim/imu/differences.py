"""Numerical derivatives and resampling of logged angles."""

from enum import Enum

import numpy as np

from armside.arrays import Array


class Scheme(Enum):
    """Difference quotient of the first derivative; the second is central in both."""

    FORWARD = "forward"
    """Thesis (5.6): half a sample early."""
    CENTRAL = "central"


def difference_quotients(phi: Array, h: float, scheme: Scheme) -> tuple[Array, Array]:
    """First and second derivative of samples (N, n) every h [s]. Thesis (5.6).

    The record is extended by its first and last sample, as if at rest beyond its ends.
    """
    if len(phi) < 3:
        raise ValueError(f"difference quotients need at least 3 samples, got {len(phi)}")
    padded = np.concatenate([phi[:1], phi, phi[-1:]])
    before, now, after = padded[:-2], padded[1:-1], padded[2:]
    second = (after - 2.0 * now + before) / h**2
    if scheme is Scheme.FORWARD:
        return (after - now) / h, second
    return (after - before) / (2.0 * h), second


def resample(time: Array, values: Array, at: Array) -> Array:
    """Samples (N, n) at other instants by a cubic spline; at rest beyond the ends.

    It needs no low-pass before it: the zero-phase filter that follows is far below both rates.
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time, values, bc_type="clamped")
    return spline(np.clip(at, time[0], time[-1]))
