"""Laws with a memory of past iterations: high order, internal model, observer, adaptive gains."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..models.system_matrix import Model
from ..records import records
from .first_order import FilteredLaw
from .model_based import tapered

Pair = tuple[Array, Array]
"""(u, e) of one iteration."""


@dataclass(frozen=True, kw_only=True)
class HighOrder(FilteredLaw):
    """u_{k+1} = Q sum_i (alpha_i u_{k-i} + beta_i L e_{k-i}), i = 0 .. p - 1. Thesis 7.3.

    u and e before iteration 0 are zero. The weights alpha and beta are equally many, newest first.
    """

    alpha: tuple[float, ...]
    beta: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.alpha or len(self.alpha) != len(self.beta):
            given = f"got {len(self.alpha)} and {len(self.beta)}"
            raise ValueError(f"alpha and beta must be equally many, at least 1, {given}")
        if not np.isfinite(self.alpha + self.beta).all():
            raise ValueError(f"alpha and beta must be finite, got {self.alpha} and {self.beta}")

    @property
    def order(self) -> int:
        return len(self.alpha)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: tuple[Pair, ...] | None = None, /
    ) -> tuple[Array, tuple[Pair, ...]]:
        pairs = ((correction, error), *(memory or ()))[: self.order]
        total, learned = np.zeros_like(correction), np.zeros_like(error)
        for alpha, beta, (u, e) in zip(self.alpha, self.beta, pairs, strict=False):
            total += alpha * u
            learned += beta * e
        return self.Q(total + self.L(learned)), pairs[: self.order - 1]


def periodic_pattern(period: int) -> tuple[float, ...]:
    """D(w) = 1 - w^period: all patterns with this period over the iterations."""
    if period < 1:
        raise ValueError(f"period must be >= 1, got {period}")
    return (1.0, *([0.0] * (period - 1)), -1.0)


def internal_model(
    pattern: ArrayLike, *, L: RecordFilter, Q: RecordFilter = ALL_PASS, pole: float = 0.1
) -> HighOrder:
    """High-order law without asymptotic error for disturbances with D(w) d_k = 0.

    pattern: coefficients (1, d_1, ..., d_p) of D in the backward iteration shift w, as
    `periodic_pattern` returns. L: an approximate inverse of T_u. pole: all p poles of the
    iteration for L T_u = 1, in [0, 1). After Chen and Moore (2002).

    With D(w) u = K(w) L e, e = e_0 - T_u u and L T_u = 1 the error is D / (D + K) e_0; K = A - D
    places the poles A(w) = (1 - pole w)^p.
    """
    D = np.asarray(pattern, dtype=np.float64)
    if D.ndim != 1 or len(D) < 2 or D[0] != 1.0 or not np.isfinite(D).all():
        raise ValueError(f"pattern must be (1, d_1, ..., d_p) with p >= 1, got {pattern}")
    if not 0.0 <= pole < 1.0:
        raise ValueError(f"pole must be in [0, 1), got {pole}")
    A = np.poly(np.full(len(D) - 1, pole))
    return HighOrder(alpha=tuple((-D[1:]).tolist()), beta=tuple((A - D)[1:].tolist()), L=L, Q=Q)


@dataclass(frozen=True, kw_only=True)
class DisturbanceObserver(FilteredLaw):
    """u_{k+1} = Q L d_hat_{k+1}, the disturbance predicted from all iterations so far.

    d_k = e_k + T_u u_k is the error without correction. It is modelled as an autoregressive
    process over the iterations whose `order` coefficients are the same at all times of the record
    and are fitted by least squares. Until there are enough iterations, d_k is the prediction.
    After the disturbance observer of Chen and Moore (2002).
    """

    T_u: Model
    order: int = 2
    """Order of the autoregressive model [iterations]."""
    ridge: float = 1e-6
    """Relative ridge regularisation of the fit: the smallest of equally good coefficients."""

    def __post_init__(self) -> None:
        if self.order < 1:
            raise ValueError(f"order must be >= 1, got {self.order}")
        if not self.ridge > 0.0:
            raise ValueError(f"ridge must be > 0, got {self.ridge}")

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: tuple[Array, ...] | None = None, /
    ) -> tuple[Array, tuple[Array, ...]]:
        observed = (*(memory or ()), error + self.T_u.simulate(correction))
        return self.Q(self.L(self._predict(observed))), observed

    def _predict(self, observed: tuple[Array, ...]) -> Array:
        """d_hat_{k+1} = sum_i c_i d_{k-i}."""
        if len(observed) <= self.order:
            return observed[-1]
        p = self.order
        normal, right = np.zeros((p, p)), np.zeros(p)
        for k in range(p, len(observed)):
            past = np.stack([observed[k - 1 - i].ravel() for i in range(p)])
            normal += past @ past.T
            right += past @ observed[k].ravel()
        rho = self.ridge * np.trace(normal) / p
        if rho == 0.0:
            return observed[-1]
        c = np.linalg.solve(normal + rho * np.eye(p), right)
        return sum((ci * observed[-1 - i] for i, ci in enumerate(c)), np.zeros_like(observed[-1]))


_FALSE_ALARM = 1e-4  # each one raises the gain again, which keeps noise


@dataclass(frozen=True, kw_only=True)
class Adaptive(FilteredLaw):
    """u_{k+1} = Q(u_k + kappa_k(t) L e_k), kappa the gain of a Kalman filter over iterations.

    The disturbance at each time t is modelled as a random walk over the iterations, observed with
    measurement noise: P <- P r_n / (P + r_n) + r_d, kappa = P / (P + r_n). The gain starts near
    1 and falls as the error becomes noise, which is then averaged instead of learned. r_d is
    estimated from the error power around t: where that exceeds P + r_n by more than noise does once
    in 10,000 samples, the gain rises again.
    Norrloef, "An adaptive iterative learning control algorithm with experiments on an industrial
    robot" (2002).
    """

    noise_variance: float
    initial_variance: float
    """r_n and P before the first iteration: variance of a measured sample, of the disturbance."""
    window: int = 25
    """Samples over which the error's power is averaged."""

    def __post_init__(self) -> None:
        for name in ("noise_variance", "initial_variance"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")
        if self.window < 1:
            raise ValueError(f"window must be >= 1 sample, got {self.window}")

    def check(self, n_samples: int, n_columns: int) -> None:
        if self.window > n_samples:
            raise ValueError(f"window must be within {n_samples} samples, got {self.window}")
        super().check(n_samples, n_columns)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Array | None = None, /
    ) -> tuple[Array, Array]:
        """memory: P(t) after the last update, shape (N, n)."""
        from scipy.special import gammaincinv

        P = np.full_like(error, self.initial_variance) if memory is None else memory
        r_n = self.noise_variance
        if memory is not None:
            power, expected = _averaged(np.square(error), self.window), P + r_n
            half = 0.5 * _counted(len(error), self.window)
            # mean square of so much unit noise that is exceeded once in 10,000 samples
            by_chance = (gammaincinv(half, 1.0 - _FALSE_ALARM) / half)[:, None]
            changed = power > by_chance * expected
            P = P + np.where(changed, power - expected, 0.0)
        kappa = P / (P + r_n)
        return self.Q(correction + kappa * self.L(error)), P * r_n / (P + r_n)


_AROUND = 5  # bins to each side over which a first power is averaged


@dataclass(frozen=True, kw_only=True, eq=False)
class FrequencyKalman:
    """Kalman filter over the iterations, one for each frequency: the gain that noise allows.

    kappa_k = P_k / (P_k + R)    u_{k+1} = u_k + L kappa_k e_k    P_{k+1} = kappa_k R + W

    P is the power of what is not learned yet, P_0 that of e_0 less R; R is that of the noise, which
    is white, W that of what changes between iterations. With W = 0 and P large kappa_k is
    1 / (k + 1): all runs so far are averaged. After Saab, "A discrete-time stochastic learning
    control algorithm" (2001), and Norrloef (2002), frequency by frequency.
    """

    L: RecordFilter
    """An inverse of T_u; whatever gain it has is taken to be right."""
    noise: float
    """Standard deviation of a measured sample, its part that does not repeat."""
    change: float = 0.0
    """Standard deviation of what changes from one iteration to the next."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.noise) and self.noise > 0.0):
            raise ValueError(f"noise must be > 0, got {self.noise}")
        if not (np.isfinite(self.change) and self.change >= 0.0):
            raise ValueError(f"change must be >= 0, got {self.change}")

    def check(self, n_samples: int, n_columns: int) -> None:
        self.L.check(n_samples, n_columns)

    @records("correction", "error")
    def step(
        self, correction: Array, error: Array, memory: Array | None = None, /
    ) -> tuple[Array, Array]:
        """memory: P after the last update, (N + 1, n), at the frequencies of 2 N samples."""
        n = len(error)
        E = np.fft.rfft(tapered(error), axis=0)
        R, W = (2 * n * level**2 for level in (self.noise, self.change))
        if (P := memory) is None:
            P = np.maximum(_averaged(np.square(np.abs(E)), 2 * _AROUND + 1) - R, 0.0)
        kappa = P / (P + R)
        learned = np.fft.irfft(kappa * E, 2 * n, axis=0)[:n]
        return correction + self.L(learned), P * R / (P + R) + W


def _averaged(power: Array, window: int) -> Array:
    """Moving average (N, n) over the rows around each, fewer of them at the ends."""
    summed = [np.convolve(column, np.ones(window), mode="same") for column in power.T]
    return np.stack(summed, axis=1) / _counted(len(power), window)[:, None]


def _counted(n: int, window: int) -> Array:
    """Rows in the window around each of n."""
    return np.convolve(np.ones(n), np.ones(window), mode="same")
