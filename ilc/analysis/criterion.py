"""Frequency-domain convergence criterion |1 - L T_u| < 1/|Q|; largest admissible gamma and cutoff.

It is sufficient for ||e_k - e_inf|| to shrink in every iteration on infinite records. (The thesis
states this for e_k itself, which holds only for Q = 1.)  Thesis (7.5), (8.13), (9.13).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import RecordFilter, ZeroPhaseButterworth
from ..models.system import Complex, System, require_stable, unit_circle

LOWEST = 1e-4
"""Lowest frequency of a grid, relative to the Nyquist frequency."""


def frequency_grid(n: int = 2000) -> Array:
    """omega [rad/sample] from near 0 to the Nyquist frequency, half by decade, half evenly."""
    low = np.geomspace(LOWEST * np.pi, np.pi, n // 2)
    return np.unique(np.concatenate((low, np.linspace(0.0, np.pi, n - n // 2 + 1)[1:])))


def hertz(omega: ArrayLike, sample_time: float) -> Array:
    """[Hz] from [rad/sample]."""
    return np.asarray(omega) / (2.0 * np.pi * sample_time)


def shift_response(gamma: float, delta: int, omega: ArrayLike) -> Complex:
    """L = gamma q^delta at omega [rad/sample]."""
    return gamma * unit_circle(omega) ** delta


@dataclass(frozen=True, eq=False)
class Criterion:
    """Both sides |1 - L T_u| and |Q| of the criterion over omega [rad/sample], shape (M,)."""

    omega: Array
    learning: Array
    q: Array

    @property
    def contraction(self) -> float:
        """sup |Q| |1 - L T_u|: the factor by which ||e_k - e_inf|| shrinks at least."""
        return float((self.q * self.learning).max())

    @property
    def limiting_omega(self) -> float:
        """Frequency of that supremum [rad/sample]."""
        return float(self.omega[(self.q * self.learning).argmax()])

    @property
    def is_met(self) -> bool:
        return self.contraction < 1.0

    def violated_bands(self) -> list[tuple[float, float]]:
        """Intervals of omega [rad/sample] in which the criterion fails."""
        bad = np.flatnonzero(self.q * self.learning >= 1.0)
        runs = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
        return [(float(self.omega[r[0]]), float(self.omega[r[-1]])) for r in runs if r.size]


def criterion(T_u: Complex, L: Complex, Q: ArrayLike, omega: Array) -> Criterion:
    """Criterion from the responses of T_u, L and Q at omega, shape (M,) each.

    With several motors, responses of shape (M, n, n) (Q: (M,) or (M, n)): |.| becomes the largest
    singular value of Q (I - T_u L), and `q` is then 1.
    """
    if T_u.ndim == 1:
        return Criterion(omega, np.abs(1.0 - L * T_u), np.abs(Q))
    q = np.asarray(Q)
    q = q[:, None, None] if q.ndim == 1 else q[:, :, None]
    iteration = q * (np.eye(T_u.shape[1]) - T_u @ L)
    return Criterion(omega, np.linalg.norm(iteration, ord=2, axis=(1, 2)), np.ones(len(omega)))


def heuristic_criterion(
    T_u: System, gamma: float, delta: int, Q: RecordFilter, omega: Array | None = None
) -> Criterion:
    """Criterion for L = gamma q^delta. Raises ValueError for an unstable T_u."""
    require_stable(T_u, "T_u")
    omega = frequency_grid() if omega is None else omega
    L = shift_response(gamma, delta, omega)
    return criterion(T_u.response(omega), L, Q.response(omega), omega)


def largest_gamma(
    T_u: System,
    deltas: ArrayLike,
    cutoffs: ArrayLike | None,
    *,
    order: int = 2,
    n_frequencies: int = 2000,
) -> Array:
    """Supremum of the gains that meet the criterion, shape (n_deltas, n_cutoffs).

    cutoffs: [Hz] of a zero-phase Butterworth Q; None: Q = 1, one column. The admissible gains are
    the interval from 0 to this value; 0: no gain is admissible.

    With z = e^{j omega delta} T_u and r = 1/Q^2 - 1 >= 0, |1 - gamma z|^2 < 1 + r is a quadratic
    inequality in gamma, solved by 0 < gamma < (Re z + sqrt(Re^2 z + |z|^2 r)) / |z|^2; the
    smallest of these over frequency counts. At omega = 0 it is 2 / |T_u(0)|.
    """
    require_stable(T_u, "T_u")
    omega = frequency_grid(n_frequencies)
    response = T_u.response(omega)
    size = np.maximum(np.abs(response), 1e-150)  # a zero on the unit circle is no bound
    cosine = np.cos(np.angle(response) + np.multiply.outer(np.asarray(deltas, float), omega))
    if cutoffs is None:
        return np.maximum((cosine + np.abs(cosine)) / size, 0.0).min(axis=1)[:, None]
    squared = np.square(cosine)
    at_rest = 2.0 / max(abs(T_u.static_gain), 1e-150)
    bounds = np.empty((len(cosine), np.size(cutoffs)))
    for column, cutoff in enumerate(np.atleast_1d(cutoffs)):
        Q = ZeroPhaseButterworth(float(cutoff), T_u.sample_time, order).response(omega)
        r = 1.0 / np.square(np.maximum(Q, 1e-150)) - 1.0
        # For any delta a frequency bounds gamma at (sqrt(1 + r) - 1) / |T_u| or above: frequencies
        # for which this exceeds the bound at rest are skipped.
        near = np.flatnonzero((np.sqrt(1.0 + r) - 1.0) / size < at_rest)
        stop = near[-1] + 1 if near.size else 1
        gamma = squared[:, :stop] + r[:stop]
        np.sqrt(gamma, out=gamma)
        gamma += cosine[:, :stop]
        gamma /= size[:stop]
        bounds[:, column] = np.minimum(gamma.min(axis=1), at_rest)
    return bounds


def largest_cutoff(
    T_u: System, gamma: float, delta: int, *, order: int = 2, n_frequencies: int = 20000
) -> float:
    """Supremum of the cutoffs [Hz] of a zero-phase Butterworth Q that meet the criterion.

    Infinity if Q = 1 is admissible; 0 if no cutoff is. Closed form: at each frequency with
    |1 - L T_u| > 1, 1/|Q| = 1 + (t/t_c)^(2 order), t = tan(omega/2), must exceed it, which bounds
    t_c.
    """
    require_stable(T_u, "T_u")
    omega = frequency_grid(n_frequencies)[:-1]  # at the Nyquist frequency itself Q is 0
    learning = np.abs(1.0 - shift_response(gamma, delta, omega) * T_u.response(omega))
    outside = learning >= 1.0
    if not outside.any():
        return np.inf
    if abs(1.0 - gamma * T_u.static_gain) >= 1.0:
        return 0.0
    excess = np.maximum(learning[outside] - 1.0, np.finfo(float).tiny)
    t_c = np.tan(omega[outside] / 2.0) * np.exp(-np.log(excess) / (2.0 * order))
    return float(np.arctan(t_c.min()) / (np.pi * T_u.sample_time))
