"""Frequency-domain convergence criterion |1 - L T_u| < 1/|Q|; largest admissible gamma and cutoff.

It is sufficient for ||e_k - e_inf|| to shrink in every iteration on infinite records. (The thesis
states this for e_k itself, which holds only for Q = 1.)  Thesis (7.5), (8.13), (9.13).

With several motors |.| is the largest singular value: of Q (I - L T_u), by which the correction
contracts, or of Q (I - T_u L) for the error. Grids are refined at the poles, so that no resonance
is missed: see `models.peak`.
"""

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array, shown

from ..filters import PerColumn, RecordFilter
from ..laws.first_order import MatrixGain, PType
from ..models.peak import peak
from ..models.system import Complex, System, require_stable, unit_circle
from ..models.system_matrix import Model
from ..records import as_real, as_whole, records

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
    bound: float | None = None
    """Guaranteed upper bound of the contraction; None: the responses were given on a grid, and
    nothing is known between its frequencies."""

    @property
    def contraction(self) -> float:
        """sup |Q| |1 - L T_u|: the factor to which ||e_k - e_inf|| falls at least."""
        return float((self.q * self.learning).max())

    @property
    def limiting_omega(self) -> float:
        """Frequency of that supremum [rad/sample]."""
        return float(self.omega[(self.q * self.learning).argmax()])

    @property
    def is_met(self) -> bool:
        """The contraction is below 1, at all frequencies where a bound is known."""
        return (self.contraction if self.bound is None else self.bound) < 1.0

    def violated_bands(self) -> list[tuple[float, float]]:
        """Intervals of omega [rad/sample] in which the criterion fails."""
        bad = np.flatnonzero(self.q * self.learning >= 1.0)
        runs = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
        return [(float(self.omega[r[0]]), float(self.omega[r[-1]])) for r in runs if r.size]


class Contracting(Enum):
    """Signal whose contraction is asked for; the same for one motor."""

    CORRECTION = "correction"
    ERROR = "error"
    """Needs one Q for all motors."""


def criterion(
    T_u: Complex,
    L: Complex,
    Q: ArrayLike,
    omega: Array,
    of: Contracting = Contracting.ERROR,
) -> Criterion:
    """Criterion from the responses of T_u, L and Q at omega, shape (M,) each.

    With several motors, responses of shape (M, n, n) (Q: (M,) or (M, n)): |.| becomes the largest
    singular value, and `q` is then 1. Nothing is known between the frequencies.
    """
    omega = as_real(omega, "omega")
    if omega.ndim != 1 or not omega.size or not np.isfinite(omega).all():
        raise ValueError(f"omega must be finite, of shape (M,) with M >= 1, got {shown(omega)}")
    T_u, L, Q = (_response(n, r, omega) for n, r in (("T_u", T_u), ("L", L), ("Q", Q)))
    if T_u.ndim == 1:
        require_one_cutoff(Q)
        return Criterion(omega, np.abs(1.0 - L * T_u), np.abs(Q))
    q = np.asarray(Q)
    q = np.broadcast_to(q[:, None] if q.ndim == 1 else q, T_u.shape[:2])
    if of is Contracting.ERROR and np.ptp(q, axis=1).any():
        raise ValueError("the contraction of the error needs one Q for all motors")
    moved = T_u @ L if of is Contracting.ERROR else L @ T_u
    iteration = q[:, :, None] * (np.eye(T_u.shape[1]) - moved)
    return Criterion(omega, np.linalg.norm(iteration, ord=2, axis=(1, 2)), np.ones(len(omega)))


def _response(name: str, response: ArrayLike, omega: Array) -> Any:
    """Response at omega (M,), or one for all of them, of one system or a matrix (M, n, n)."""
    values = np.asarray(response)
    if values.dtype.kind not in "iufc" or not np.isfinite(values).all():
        raise ValueError(f"{name} must be finite numbers, got {shown(response)}")
    if values.ndim and len(values) != len(omega):
        raise ValueError(f"{name} must have {len(omega)} rows as omega, got shape {values.shape}")
    if name == "T_u" and not (values.ndim == 1 or (values.ndim == 3 and values.size)):
        raise ValueError(f"T_u must have shape (M,) or (M, n, n), got {values.shape}")
    return values


def require_one_sample_time(T_u: Any, *filters: Any) -> None:
    """Raise ValueError for filters whose sample time is not that of the model T_u."""
    for one in filters:
        own = getattr(one, "sample_time", T_u.sample_time)
        if not np.isclose(own, T_u.sample_time, rtol=1e-9, atol=0.0):
            name = type(one).__name__
            text = f"the sample time {T_u.sample_time:g} s of T_u, got {own:g} s"
            raise ValueError(f"{name} must have {text}")


def require_one_cutoff(Q: ArrayLike) -> None:
    """Raise ValueError for a response of several cutoffs."""
    if np.ndim(Q) > 1:
        raise ValueError("Q with several cutoffs needs a matrix of systems as T_u")


def heuristic_criterion(
    T_u: Model,
    gamma: PerColumn | Array,
    delta: int | tuple[int, ...],
    Q: RecordFilter,
    omega: Array | None = None,
) -> Criterion:
    """Criterion for L = gamma q^delta.

    Args:
        T_u: one system, or a matrix of systems for coupled motors.
        gamma: one gain; for a matrix of systems also one for each motor or a matrix (n, n).
        delta: one shift, or one for each motor.
        omega: frequencies [rad/sample]; None: a grid refined at the poles until the contraction is
            known to 1e-9, if Q has `poles`.
    """
    require_stable(T_u, "T_u")
    L = heuristic_gain(T_u, gamma, delta)
    require_one_sample_time(T_u, Q)

    def at(omega: Array) -> Criterion:
        T, gain, q = T_u.response(omega), L.response(omega), Q.response(omega)
        return criterion(T, gain, q, omega, Contracting.CORRECTION)

    def power(omega: Array) -> Array:
        return np.square(at(omega).learning * at(omega).q)

    poles = iteration_poles(T_u, delta, Q)
    if omega is not None or poles is None:
        return at(frequency_grid() if omega is None else omega)
    largest = peak(power, poles, frequency_grid())
    return replace(at(largest.omega), bound=float(np.sqrt(largest.bound)))


def iteration_poles(T_u: Model, delta: int | tuple[int, ...], Q: RecordFilter) -> Complex | None:
    """Poles of Q (1 - gamma q^delta T_u), those at the origin included; None if Q states none."""
    poles = getattr(Q, "poles", None)
    if poles is None:
        return None
    lead = np.zeros(int(np.abs(as_whole(delta, "delta")).max()))
    return np.concatenate((T_u.all_poles, poles, lead)).astype(np.complex128)


def heuristic_gain(
    T_u: Model, gamma: PerColumn | Array, delta: int | tuple[int, ...]
) -> PType | MatrixGain:
    """L = gamma q^delta for one system or for all motors of a matrix of systems."""
    if isinstance(T_u, System):
        if np.ndim(gamma) or np.ndim(delta):
            raise ValueError("gamma and delta for each motor need a matrix of systems as T_u")
        shift = int(as_whole(delta, "delta"))
        return PType(gamma=float(np.asarray(gamma)), delta=shift)
    if T_u.n_outputs != T_u.n_inputs:
        given = f"{T_u.n_outputs} and {T_u.n_inputs}"
        raise ValueError(f"L = gamma q^delta needs as many outputs as inputs of T_u, got {given}")
    gains = np.asarray(gamma, dtype=np.float64)
    n = T_u.n_inputs
    return MatrixGain(gamma=gains if gains.ndim == 2 else gains * np.eye(n), delta=delta)


@records("first_error")
def asymptotic_error(
    first_error: Array, T_u: Model, L: RecordFilter, Q: RecordFilter, n_padding: int = 0
) -> Array:
    """e_inf of u_{k+1} = Q(u_k + L e_k), shape (N, n), from e_0, the error without correction.

    E_inf = (1 - Q) E_0 / (1 - Q (1 - T_u L)); for coupled motors E_inf = E_0 - T_u U_inf with
    (I - Q (I - L T_u)) U_inf = Q L E_0. A repeating load w is part of e_0 = e - T_w w.
    The record is treated as one period; n_padding zeros after it represent a record that begins
    and ends at rest.
    """
    n_samples = len(first_error)
    length = n_samples + n_padding
    require_stable(T_u, "T_u")
    require_one_sample_time(T_u, L, Q)
    omega = 2.0 * np.pi * np.fft.rfftfreq(length)
    E = np.fft.rfft(first_error, length, axis=0)
    T, L_response, q = T_u.response(omega), L.response(omega), Q.response(omega)
    if T.ndim == 1 and L_response.ndim == 3:
        T = T[:, None, None] * np.eye(L_response.shape[2])
    if T.ndim == 3:
        limit = _coupled(E, T, as_matrices(L_response, T.shape[2]), as_matrices(q, T.shape[2]))
    else:
        T, L_response, q = (each.reshape(len(T), -1) for each in (T, L_response, q))
        cutoffs = q.shape[1]
        if cutoffs not in (1, E.shape[1]):
            raise ValueError(f"Q has {cutoffs} cutoffs, the error {E.shape[1]} columns")
        denominator = 1.0 - q * (1.0 - T * L_response)
        _require_limit(float(np.abs(denominator).min()))
        limit = (1.0 - q) / denominator * E
    return np.fft.irfft(limit, length, axis=0)[:n_samples]


def _coupled(E: Complex, T: Complex, L: Complex, Q: Complex) -> Complex:
    """Limit of the error's spectrum (M, n) for responses (M, n, n)."""
    identity = np.eye(T.shape[2])
    left = identity - Q @ (identity - L @ T)
    _require_limit(float(np.linalg.norm(left, ord=-2, axis=(1, 2)).min()))
    U = np.linalg.solve(left, Q @ L @ E[:, :, None])
    return (E[:, :, None] - T @ U)[:, :, 0]


def as_matrices(response: Array | Complex, n: int) -> Complex:
    """Response of shape (M,), of each motor (M, n), or (M, n, p), as the last."""
    if response.ndim == 3:
        return response.astype(np.complex128)
    columns = response[:, None] if response.ndim == 1 else response
    return (columns[:, :, None] * np.eye(n)).astype(np.complex128)


def _require_limit(smallest: float) -> None:
    if smallest < 1e-12:
        raise ValueError("no asymptotic error: Q (1 - T_u L) is 1 at some frequency")
