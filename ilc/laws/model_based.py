"""Learning filters and laws from a model of T_u: its adjoint and its inverses.

`ModelInverse` is Algorithm 2 of the thesis. `RegularisedInverse` is a law for several outputs and
inputs; of all corrections with the same effect it chooses the one with the smallest norm in S,

    U_{k+1} = Q (U_k + gamma L E_k)        L = (G^H W G + rho S^-2)^-1 G^H W

W weights the outputs and S scales the inputs; G need be neither square nor invertible. The record
is extended by a taper from its last value to its first, which leaves no step for L to amplify.
"""

from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, check_numbers

from ..filters import RecordFilter
from ..models.system import Complex, require_stable
from ..models.system_matrix import (
    AnyModel,
    Model,
    check_inputs,
    check_model,
    require_effect,
    require_time_invariant,
)
from ..records import records
from .first_order import FirstOrderLaw


@dataclass(frozen=True, kw_only=True, eq=False)
class Gradient:
    """L = step T_u^T on the finite record; converges for 0 < step < 2 / max |T_u|^2.

    Of a model along the record the maximum is the 2-norm of its lifted matrix.
    """

    T_u: AnyModel
    step: float = 0.0
    """0 chooses 1 / max |T_u|^2, for which no frequency of the error grows."""

    def __post_init__(self) -> None:
        check_model(self.T_u)
        top = 2.0 / require_effect(self.T_u) ** 2
        if self.step == 0.0:
            object.__setattr__(self, "step", 0.5 * top)
        elif not 0.0 < self.step < top:
            needed = f"above 0 and below 2/max|T_u|^2 = {top:.6g}"
            raise ValueError(f"step must be {needed}, got {self.step}")

    def check(self, n_samples: int, n_columns: int) -> None:
        check_inputs(self.T_u, n_columns)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        return self.step * self.T_u.adjoint(signal)

    def response(self, omega: ArrayLike) -> Complex:
        T = require_time_invariant(self.T_u, "a response").response(omega)
        return self.step * (T if T.ndim == 1 else T.swapaxes(1, 2)).conj()


_SINGULAR = 1e-10  # singular values, relative to the largest, of which six digits are known
_LEARNED = 1e-9  # 1 - H_B above which a frequency counts as learned


class Beyond(Enum):
    """Extension of a record beyond its ends that the inverse assumes."""

    TAPERED_HOLD = "tapered hold"
    """End values, faded to zero over one record length: no step for L to amplify."""
    PERIODIC = "periodic"
    """Periodic continuation, as in repetitive control."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelInverse:
    """L(omega) = T_u^H (T_u T_u^H + rho)^-1 (1 - H_B). Thesis 7.5, Algorithm 2.

    T_u has a delay and may have zeros outside the unit circle, so the inverse is not causal and is
    applied by FFT. With an exact model the error at each frequency falls by H_B an iteration.
    """

    T_u: Model
    learned: RecordFilter
    """Low-pass in 1 - H_B; its passband is learned."""
    rate: float = 1.0
    """1 - H_B = rate * learned; with 1, errors in the passband vanish in one iteration."""
    regularisation: float = 0.0
    """rho relative to the largest |T_u|^2; bounds L where T_u is small."""
    beyond: Beyond = Beyond.TAPERED_HOLD

    def __post_init__(self) -> None:
        if not 0.0 < self.rate < 2.0:
            raise ValueError(f"rate must be in (0, 2) for the error to shrink, got {self.rate}")
        if not (np.isfinite(self.regularisation) and self.regularisation >= 0.0):
            raise ValueError(f"regularisation must be >= 0, got {self.regularisation}")
        require_stable(self.T_u, "T_u")
        object.__setattr__(self, "_rho", self.regularisation * require_effect(self.T_u) ** 2)

    _rho: float = field(init=False, repr=False)

    def check(self, n_samples: int, n_columns: int) -> None:
        check_inputs(self.T_u, n_columns)

    def response(self, omega: ArrayLike) -> Complex:
        """(M,), or (M, m, p) for several inputs and outputs.

        Raises ValueError where the regularisation is 0 and T_u has no inverse, or one that is not
        known to 1e-6.
        """
        T = self.T_u.response(omega)
        learned = self.rate * self.learned.response(omega)
        if T.ndim == 1:
            power = np.square(np.abs(T)) + self._rho
            _require_inverse(power == 0.0, learned)
            return learned * T.conj() / np.where(power == 0.0, 1.0, power)
        learned = learned if learned.ndim == 2 else learned[:, None]
        U, s, V_H = np.linalg.svd(T, full_matrices=False)
        if self._rho == 0.0:
            _require_inverse(s[:, -1] <= _SINGULAR * s[:, 0], learned.max(axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = np.nan_to_num(s / (np.square(s) + self._rho), nan=0.0, posinf=0.0)
        inverse = (V_H.conj().swapaxes(1, 2) * gain[:, None, :]) @ U.conj().swapaxes(1, 2)
        return (inverse * learned[:, None, :]).astype(np.complex128)

    @records("signal")
    def __call__(self, signal: Array, /) -> Array:
        n_samples = len(signal)
        extended = signal
        if self.beyond is Beyond.TAPERED_HOLD:
            fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, n_samples + 1) / (n_samples + 1))
            # FFT index -1 is the sample before the first: the fade-in stands at the end.
            after, before = np.outer(fade, signal[-1]), np.outer(fade[::-1], signal[0])
            extended = np.concatenate((signal, after, before))
        spectrum = np.fft.rfft(extended, axis=0)
        L = self.response(2.0 * np.pi * np.fft.rfftfreq(len(extended)))
        matrix = L.ndim == 3
        moved = (L @ spectrum[:, :, None])[:, :, 0] if matrix else L.reshape(len(L), -1) * spectrum
        return np.fft.irfft(moved, len(extended), axis=0)[:n_samples]


def _require_inverse(singular: NDArray[np.bool_], learned: Array) -> None:
    if (singular & (np.abs(learned) > _LEARNED)).any():
        raise ValueError("T_u has no inverse at a frequency that is learned: regularisation > 0")


class Response(Protocol):
    """Linear model with a frequency response."""

    def response(self, omega: ArrayLike) -> Complex:
        """(M, p, n) at omega (M,) [rad/sample]."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class RegularisedInverse(FirstOrderLaw):
    """First-order law from errors of p outputs, (N, p), to corrections of n inputs, (N, n)."""

    G: Response
    """Response of the output to the correction."""
    sample_time: float
    cutoff: float
    """[Hz] of Q = 1 / (1 + (f / cutoff)^sharpness), which has no phase."""
    sharpness: int = 8
    gamma: float = 0.8
    """Learning gain, in (0, 2)."""
    output_weight: tuple[float, ...]
    input_size: tuple[float, ...]
    """(n,), diagonal of S, > 0; weights: (p,), roots of W's diagonal, 0 for no learning."""
    regularisation: float = 0.01
    """rho relative to the largest static gain of W^1/2 G S, squared."""
    limit: float = np.inf
    """Largest correction of each input, relative to its size."""

    def __post_init__(self) -> None:
        check_numbers(self, "sample_time", "cutoff", "gamma", "regularisation", "limit")
        check_numbers(self, "output_weight", "input_size", several=True)
        if not 0.0 < self.cutoff < (top := 0.5 / self.sample_time):
            raise ValueError(f"cutoff must be above 0 and below {top:g} Hz, got {self.cutoff}")
        if not 0.0 < self.gamma < 2.0:
            raise ValueError(f"gamma must be in (0, 2), got {self.gamma}")
        if not (np.isfinite(self.regularisation) and self.regularisation > 0.0):
            raise ValueError(f"regularisation must be > 0, got {self.regularisation}")
        weight, size = np.array(self.output_weight), np.array(self.input_size)
        if not ((weight >= 0.0).all() and weight.any()):
            raise ValueError(f"output_weight must be >= 0 and not all 0, got {self.output_weight}")
        if not (size > 0.0).all():
            raise ValueError(f"input_size must be > 0, got {self.input_size}")
        if not self.limit > 0.0:
            raise ValueError(f"limit must be > 0, got {self.limit}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if (n := len(self.input_size)) != n_columns:
            raise ValueError(f"the law has {n} inputs, the record {n_columns} columns")

    def Q(self, omega: ArrayLike) -> Array:
        """Real, (M,), at omega [rad/sample]."""
        f = np.asarray(omega, dtype=np.float64) / (2.0 * np.pi * self.sample_time)
        return 1.0 / (1.0 + (f / self.cutoff) ** self.sharpness)

    def L(self, omega: ArrayLike) -> Complex:
        """(M, n, p) at omega (M,) [rad/sample]."""
        weight, size = np.array(self.output_weight), np.array(self.input_size)

        def scaled(at: ArrayLike) -> Complex:
            return weight[:, None] * self.G.response(at) * size

        T = scaled(omega)
        rho = self.regularisation * np.linalg.norm(scaled(np.zeros(1))[0], ord=2) ** 2
        T_H = np.conj(np.swapaxes(T, 1, 2))
        inverse = np.linalg.solve(T_H @ T + rho * np.eye(len(size)), T_H)
        return np.asarray(size[:, None] * inverse * weight, dtype=np.complex128)

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n_samples = len(correction)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n_samples)
        E, U = (np.fft.rfft(tapered(signal), axis=0) for signal in (error, correction))
        learned = U + self.gamma * (self.L(omega) @ E[:, :, None])[:, :, 0]
        u = np.fft.irfft(self.Q(omega)[:, None] * learned, 2 * n_samples, axis=0)[:n_samples]
        return _limited(self, u)

    def contraction(self, omega: ArrayLike, plant: Response) -> Array:
        """(M,): largest singular value of Q (1 - gamma L G) on a plant, inputs in their size.

        Below 1 at each frequency the correction converges monotonically.
        """
        size = np.array(self.input_size)
        LG = self.L(omega) @ plant.response(omega)
        moved = np.eye(len(size)) - self.gamma * LG / size[:, None] * size
        return self.Q(omega) * np.linalg.norm(moved, ord=2, axis=(1, 2))


@records("signal")
def tapered(signal: Array) -> Array:
    """Record (N, n) followed by a taper from its last value to its first: (2 N, n), periodic."""
    n = len(signal)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))
    return np.concatenate((signal, signal[0] + np.outer(fade, signal[-1] - signal[0])))


_PASSED = 1e-3
"""Gain of Q below which nothing is learned."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScheduledInverse(FirstOrderLaw):
    """u_{k+1} = Q (u_k + gamma sum_s w_s(t) L_s e_k) for a plant that varies along the record."""

    laws: tuple[RegularisedInverse, ...]
    """Of each place; Q, gain and limit of the first serve all."""
    weights: Array
    """(N, S), >= 0, rows of sum 1."""

    def __post_init__(self) -> None:
        if self.weights.ndim != 2 or self.weights.shape[1] != len(self.laws):
            shape = f"(N, {len(self.laws)})"
            raise ValueError(f"weights must have shape {shape}, got {self.weights.shape}")
        if not np.allclose(self.weights.sum(axis=1), 1.0):
            raise ValueError("weights of each sample must have the sum 1")

    def check(self, n_samples: int, n_columns: int) -> None:
        if len(self.weights) != n_samples:
            raise ValueError(f"weights cover {len(self.weights)} samples, the record {n_samples}")
        self.laws[0].check(n_samples, n_columns)

    @cached_property
    def _passed(self) -> Array:
        """(M,) [rad/sample], frequencies of the tapered record that Q passes."""
        omega: Array = 2.0 * np.pi * np.fft.rfftfreq(2 * len(self.weights)).astype(np.float64)
        return omega[: int((self.laws[0].Q(omega) > _PASSED).sum())]

    @cached_property
    def _inverses(self) -> list[Complex]:
        return [law.L(self._passed) for law in self.laws]

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        n, first = len(correction), self.laws[0]
        E = np.fft.rfft(tapered(error), axis=0)[: len(self._passed), :, None]
        learned = np.zeros_like(correction)
        for weight, L in zip(self.weights.T, self._inverses, strict=True):
            spectrum = np.zeros((n + 1, correction.shape[1]), dtype=np.complex128)
            spectrum[: len(self._passed)] = (L @ E)[:, :, 0]
            learned += weight[:, None] * np.fft.irfft(spectrum, 2 * n, axis=0)[:n]
        wanted = np.fft.rfft(tapered(correction + first.gamma * learned), axis=0)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n)
        u = np.fft.irfft(first.Q(omega)[:, None] * wanted, 2 * n, axis=0)[:n]
        return _limited(first, u)


def _limited(law: RegularisedInverse, u: Array) -> Array:
    """Correction (N, n) within the limit of each input."""
    largest = law.limit * np.array(law.input_size)
    return np.clip(u, -largest, largest)
