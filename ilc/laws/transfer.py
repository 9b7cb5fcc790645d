"""Corrections that are functions of the reference, whose parameters serve other references.

Basis functions, linear in their parameters:

    u = Psi(r) theta        theta_{k+1} = arg min ||e_k - T_u Psi (theta - theta_k)||^2
                                                  + rho ||theta - theta_k||^2

Psi holds derivatives of the reference r (van der Meulen, Tousain and Bosgra, 2008; van de Wijdeven
and Bosgra, 2010) and hysteresis operators (`identification.friction.stops`), which friction needs.

Rational basis functions, Bolder and Oomen (2015), in psi_i = ((1 - q^-1) / T)^i:

    u = A(q) / B(q) r        A = sum_i a_i psi_i        B = 1 + sum_i b_i psi_i

Zeros of B make an exact inverse of a plant with zeros. ||e_k - T_u (u - u_k)|| is not convex in b;
it is minimised by least squares weighted with the last B (Sanathanan and Koerner), the best kept.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex, System, require_stable, unit_circle
from ..models.system_matrix import AnyModel, check_inputs, check_model, n_outputs_of
from ..records import as_number, as_real, as_record, as_whole, records
from .first_order import FirstOrderLaw

LARGEST_ORDER = 10
"""Of a derivative. ESTIMATE: each difference divides rounding by the sample time."""


@records("reference")
def derivatives(reference: Array, sample_time: float, order: int = 4) -> Array:
    """(N, n, order): derivatives 1 .. order of each column, central differences [1/s]."""
    as_number(sample_time, "sample_time", 0.0)
    if not 1 <= as_whole(order, "order") <= LARGEST_ORDER:
        raise ValueError(f"order must be 1 to {LARGEST_ORDER}, got {order}")
    if len(reference) < 2:
        raise ValueError(f"reference must have at least 2 samples, got {len(reference)}")
    found, last = [], reference
    for _ in range(order):
        last = np.gradient(last, sample_time, axis=0)
        found.append(last)
    return np.stack(found, axis=2)


def led(basis: Array, leads: Sequence[int]) -> Array:
    """(N, n, p m): functions (N, n, p) that come `leads` samples earlier, each of m leads."""
    rows = [np.clip(np.arange(len(basis)) + lead, 0, len(basis) - 1) for lead in leads]
    return np.concatenate([basis[row] for row in rows], axis=2)


def across(basis: Array) -> Array:
    """(N, n, n p): every column has the functions of all columns, for a coupled plant."""
    n_samples, n, p = basis.shape
    return np.repeat(basis.reshape(n_samples, 1, n * p), n, axis=1)


def correction_of(basis: Array, parameters: Array) -> Array:
    """u = Psi theta, (N, n), of a basis (N, n, p) and parameters (n, p)."""
    return np.einsum("tnp,np->tn", basis, parameters)


def fitted(bases: Sequence[Array], corrections: Sequence[Array], ridge: float = 1e-6) -> Array:
    """Parameters (n, p) nearest to learned corrections (N, n) of several references together.

    ridge: relative to the mean square of each function. Functions that are zero get none.
    """
    if len(bases) != len(corrections) or not bases:
        raise ValueError(f"{len(bases)} bases and {len(corrections)} corrections are no pairs")
    if not (np.isfinite(ridge) and ridge > 0.0):
        raise ValueError(f"ridge must be > 0, got {ridge}")
    learned = [as_record(u, "a correction") for u in corrections]
    Psi, u = np.concatenate(list(bases)), np.concatenate(learned)
    return np.stack([_ridge(Psi[:, j], u[:, j], ridge) for j in range(u.shape[1])])


def _ridge(A: Array, b: Array, ridge: float) -> Array:
    size = np.sqrt(np.square(A).mean(axis=0))
    size[size == 0.0] = np.inf
    Z = A / size
    normal = Z.T @ Z + ridge * len(Z) * np.eye(Z.shape[1])
    return np.linalg.solve(normal, Z.T @ b) / size


@dataclass(frozen=True, kw_only=True, eq=False)
class BasisFunctions(FirstOrderLaw):
    """Norm-optimal law within a basis; a correction outside it is projected onto it."""

    T_u: AnyModel
    basis: Array
    """(N, n, p): p functions of each column."""
    ridge: float = 1e-9
    """rho, relative to the mean square of each function's response."""

    def __post_init__(self) -> None:
        check_model(self.T_u)
        basis = as_real(self.basis, "basis")
        if basis.ndim != 3 or 0 in basis.shape or not np.isfinite(basis).all():
            raise ValueError(f"basis must be finite, of shape (N, n, p), got {basis.shape}")
        if not (np.isfinite(self.ridge) and self.ridge > 0.0):
            raise ValueError(f"ridge must be > 0, got {self.ridge}")
        check_inputs(self.T_u, basis.shape[1])
        n_samples, n, p = basis.shape
        found = np.empty((n_samples * n_outputs_of(self.T_u, n), n, p))
        for j in range(n):
            for i in range(p):
                alone = np.zeros((n_samples, n))
                alone[:, j] = basis[:, j, i]
                found[:, j, i] = self.T_u.simulate(alone).ravel()
        object.__setattr__(self, "basis", basis)
        object.__setattr__(self, "_response", found.reshape(len(found), n * p))

    _response: Array = field(init=False, repr=False)
    """(N q, n p), the q outputs for each parameter."""

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n_samples, n_columns) != self.basis.shape[:2]:
            needed = f"basis is for records of shape {self.basis.shape[:2]}"
            raise ValueError(f"{needed}, the record has {(n_samples, n_columns)}")

    @records("correction")
    def parameters(self, correction: Array) -> Array:
        """(n, p) of a correction (N, n), nearest to it."""
        return fitted([self.basis], [correction], 1e-12)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        if error.size != len(self._response):
            needed = (len(self.basis), len(self._response) // len(self.basis))
            raise ValueError(f"error must have shape {needed}, got {error.shape}")
        change = _ridge(self._response, error.ravel(), self.ridge).reshape(self.basis.shape[1:])
        return correction_of(self.basis, self.parameters(correction) + change)


_ROUNDS = 15
Response = Callable[[ArrayLike], Complex]


@dataclass(frozen=True, eq=False)
class Rational:
    """Parameters of A and B, which any reference may be given to."""

    a: Array
    """(p,) of psi_1 .. psi_p [s^i]."""
    b: Array
    """(m,) of psi_1 .. psi_m [s^i]."""
    sample_time: float

    def denominator(self, omega: ArrayLike) -> Complex:
        """B at omega [rad/sample]."""
        return 1.0 + self._sum(self.b, omega)

    def response(self, omega: ArrayLike) -> Complex:
        """A / B at omega [rad/sample]."""
        return np.asarray(self._sum(self.a, omega) / self.denominator(omega), dtype=np.complex128)

    def _sum(self, coefficients: Array, omega: ArrayLike) -> Complex:
        """Sum of c_i psi_i, i from 1."""
        psi = _difference(omega, self.sample_time)
        return np.asarray(psi * np.polyval(coefficients[::-1], psi), dtype=np.complex128)

    @records("reference")
    def correction(self, reference: Array) -> Array:
        """u = A / B r (N, n), of a reference that is at rest at both ends.

        Applied by FFT with a record of rest before and after, so poles outside the unit circle are
        run backwards in time: u may begin before the motion does.
        """
        return _through(self.response, reference)


@dataclass(frozen=True, kw_only=True, eq=False)
class RationalBasis(FirstOrderLaw):
    """Law whose correction is A / B r, one A and B for all columns, plant with one system T_u."""

    T_u: System
    reference: Array
    """r, shape (N, n), at rest at both ends."""
    n_numerator: int = 4
    n_denominator: int = 2

    def __post_init__(self) -> None:
        require_stable(self.T_u, "T_u")
        object.__setattr__(self, "reference", as_record(self.reference, "reference"))
        if self.n_numerator < 1 or self.n_denominator < 0:
            counts = f"{self.n_numerator} and {self.n_denominator}"
            raise ValueError(f"at least 1 numerator and 0 denominator terms, got {counts}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n_samples, n_columns) != np.shape(self.reference):
            needed = f"the shape {np.shape(self.reference)} of the reference"
            raise ValueError(f"records must have {needed}, got {(n_samples, n_columns)}")

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        return self.parameters(correction, error).correction(self.reference)

    @records("correction", "error")
    def parameters(self, correction: Array, error: Array) -> Rational:
        """The parameters of the next correction."""
        T = self.T_u.sample_time
        wanted = error + self.T_u.simulate(correction)  # what T_u u should be
        moved = self.T_u.simulate(self.reference - self.reference[0])
        found = Rational(np.zeros(self.n_numerator), np.zeros(self.n_denominator), T)
        best, smallest = found, np.inf
        for _ in range(_ROUNDS):
            found = self._weighted(found, wanted, moved)
            left = wanted - self.T_u.simulate(found.correction(self.reference))
            if (size := float(np.linalg.norm(left))) < smallest:
                best, smallest = found, size
        return best

    def _weighted(self, last: Rational, wanted: Array, moved: Array) -> Rational:
        """Minimum of ||(B wanted - A moved) / B_last||."""
        T, p, m = self.T_u.sample_time, self.n_numerator, self.n_denominator

        def term(signal: Array, i: int) -> Array:
            def response(omega: ArrayLike) -> Complex:
                return np.asarray(_difference(omega, T) ** i / last.denominator(omega))

            return _through(response, signal).ravel()

        columns = [term(moved, i + 1) for i in range(p)]
        columns += [-term(wanted, i + 1) for i in range(m)]
        A = np.stack(columns, axis=1)
        size = np.linalg.norm(A, axis=0)
        size[size == 0.0] = 1.0
        c = np.linalg.lstsq(A / size, term(wanted, 0), rcond=1e-13)[0] / size
        return Rational(c[:p], c[p:], T)


def _difference(omega: ArrayLike, sample_time: float) -> Complex:
    """psi_1."""
    return np.asarray((1.0 - 1.0 / unit_circle(omega)) / sample_time, dtype=np.complex128)


def _through(response: Response, signal: Array) -> Array:
    """Filter a record (N, n) by a response, rest before and after it."""
    n = len(signal)
    held = np.concatenate((signal, np.repeat(signal[-1:], n, axis=0)))
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, 2 * n + 1) / (2 * n + 1))
    back = signal[0] + np.outer(fade, signal[-1] - signal[0])
    whole = np.concatenate((held, back)) - signal[0]
    omega = 2.0 * np.pi * np.fft.rfftfreq(len(whole))
    spectrum = np.fft.rfft(whole, axis=0)
    return np.fft.irfft(response(omega)[:, None] * spectrum, len(whole), axis=0)[:n]
