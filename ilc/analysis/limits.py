"""Largest gain and cutoff that meet the convergence criterion, in closed form for one motor.

Both are smallest values over frequency. The grid resolves every pole of T_u, and each
smallest value is located between its neighbours.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..filters import ZeroPhaseButterworth
from ..models.conversion import as_system
from ..models.peak import AllPassPhase
from ..models.state_space import StateSpace
from ..models.system import Complex, System, require_stable
from ..records import as_number, as_real, as_whole
from .criterion import frequency_grid, shift_response

_ZOOMS = 8  # halvings of the grid around a smallest value: its error falls by 4 in each


def _grid(T_u: System, deltas: ArrayLike, n: int) -> Array:
    lead = np.zeros(int(np.abs(np.asarray(deltas)).max()))
    poles = np.concatenate((T_u.all_poles, lead)).astype(np.complex128)
    return np.unique(np.concatenate((frequency_grid(n), AllPassPhase(poles).grid())))


def largest_gamma(
    T_u: System | StateSpace,
    deltas: ArrayLike,
    cutoffs: ArrayLike | None,
    *,
    order: int = 2,
) -> Array:
    """Supremum of the gains that meet the criterion, shape (n_deltas, n_cutoffs).

    cutoffs: [Hz] of a zero-phase Butterworth Q; None: Q = 1, one column. The admissible gains are
    the interval from 0 to this value; 0: no gain is admissible.

    With z = e^{j omega delta} T_u and r = 1/Q^2 - 1 >= 0, |1 - gamma z|^2 < 1 + r is a quadratic
    inequality in gamma, solved by 0 < gamma < (Re z + sqrt(Re^2 z + |z|^2 r)) / |z|^2; the
    smallest of these over frequency counts. At omega = 0 it is 2 / |T_u(0)|.
    """
    T_u = require_stable(as_system(T_u), "T_u")
    deltas = np.atleast_1d(as_whole(deltas, "deltas")).astype(np.float64)
    cutoffs = None if cutoffs is None else np.atleast_1d(as_real(cutoffs, "cutoffs"))
    for name, given in (("deltas", deltas), ("cutoffs", cutoffs)):
        if given is not None and (given.ndim != 1 or not given.size):
            raise ValueError(f"{name} must have shape (m,) with m >= 1, got {given.shape}")
    omega = _grid(T_u, deltas, 2000)
    size, phase = _polar(T_u.response(omega))
    cosine = np.cos(phase + np.multiply.outer(deltas, omega))
    if cutoffs is None:
        return np.maximum((cosine + np.abs(cosine)) / size, 0.0).min(axis=1)[:, None]
    squared = np.square(cosine)
    at_rest = 2.0 / max(abs(T_u.static_gain), 1e-150)
    bounds = np.empty((len(deltas), len(cutoffs)))
    lowest = np.empty(bounds.shape, dtype=np.intp)
    for column, cutoff in enumerate(cutoffs):
        r = _excess(ZeroPhaseButterworth(float(cutoff), T_u.sample_time, order).response(omega))
        # For any delta a frequency bounds gamma at (sqrt(1 + r) - 1) / |T_u| or above: frequencies
        # for which this exceeds the bound at rest are skipped.
        near = np.flatnonzero((np.sqrt(1.0 + r) - 1.0) / size < at_rest)
        stop = near[-1] + 1 if near.size else 1
        gamma = squared[:, :stop] + r[:stop]
        np.sqrt(gamma, out=gamma)
        gamma += cosine[:, :stop]
        gamma /= size[:stop]
        lowest[:, column] = found = gamma.argmin(axis=1)
        bounds[:, column] = gamma[np.arange(len(deltas)), found]

    def at(omega: Array) -> Array:
        """Largest gain at a frequency of each (delta, cutoff)."""
        size, phase = _polar(T_u.response(omega))
        cosine = np.cos(phase + deltas[:, None] * omega)
        Q = [
            ZeroPhaseButterworth(float(cutoff), T_u.sample_time, order).response(column)
            for cutoff, column in zip(cutoffs, omega.T, strict=True)
        ]
        return (cosine + np.sqrt(np.square(cosine) + _excess(np.stack(Q, axis=1)))) / size

    return np.minimum(_zoomed(at, omega, lowest, bounds), at_rest)


def _polar(response: Complex) -> tuple[Array, Array]:
    """Size, at least 1e-150, for a zero on the unit circle is no bound, and phase."""
    return np.maximum(np.abs(response), 1e-150), np.angle(response)


def _excess(Q: Array) -> Array:
    """1/Q^2 - 1, not below 0 by rounding."""
    return np.maximum(1.0 / np.square(np.maximum(Q, 1e-150)) - 1.0, 0.0)


def _zoomed(
    value: Callable[[Array], Array], omega: Array, lowest: NDArray[np.intp], found: Array
) -> Array:
    """Smallest values between the neighbours of those found on a grid, at the indices `lowest`."""
    centre = omega[lowest]
    reach = np.maximum(
        omega[np.minimum(lowest + 1, len(omega) - 1)] - centre,
        centre - omega[np.maximum(lowest - 1, 0)],
    )
    for _ in range(_ZOOMS):
        reach = 0.5 * reach
        for side in (-reach, reach):
            tried = np.clip(centre + side, omega[0], np.pi)
            there = value(tried)
            better = there < found
            centre, found = np.where(better, tried, centre), np.where(better, there, found)
    return found


def largest_cutoff(
    T_u: System | StateSpace,
    gamma: float,
    delta: int,
    *,
    order: int = 2,
) -> float:
    """Supremum of the cutoffs [Hz] of a zero-phase Butterworth Q that meet the criterion.

    Infinity if Q = 1 is admissible; 0 if no cutoff is. Closed form: at each frequency with
    |1 - L T_u| > 1, 1/|Q| = 1 + (t/t_c)^(2 order), t = tan(omega/2), must exceed it, which bounds
    t_c.
    """
    T_u = require_stable(as_system(T_u), "T_u")
    as_number(gamma, "gamma", 0.0)
    as_number(as_whole(delta, "delta"), "delta")
    omega = _grid(T_u, delta, 20000)[:-1]  # at the Nyquist frequency itself Q is 0

    def at(omega: Array) -> Array:
        """t_c, infinite where the criterion is met without Q."""
        learning = np.abs(1.0 - shift_response(gamma, delta, omega) * T_u.response(omega))
        with np.errstate(divide="ignore"):
            excess = np.log(np.maximum(learning - 1.0, np.finfo(float).tiny))
        limit = np.tan(omega / 2.0) * np.exp(-excess / (2.0 * order))
        return np.where(learning >= 1.0, limit, np.inf)

    t_c = at(omega)
    if np.isinf(t_c).all():
        return np.inf
    if abs(1.0 - gamma * T_u.static_gain) >= 1.0:
        return 0.0
    lowest = np.array([t_c.argmin()])
    t_c = _zoomed(at, omega, lowest, t_c[lowest])
    return float(np.arctan(t_c[0]) / (np.pi * T_u.sample_time))
