"""Frequency response matrices with uncertainty, from periodic experiments.

    G(k) = Y(k) U(k)^-1        Y: outputs by experiments, U: inputs by experiments, at line k

Noise is what differs between the periods of one experiment. With several realisations of the input
(other phases, equal power) the variance between them holds the nonlinear distortions of the system
too, and is the one that intervals are built from. Pintelon and Schoukens, "System Identification:
A Frequency Domain Approach", 2nd ed., sections 2.7 and 4.3 (the robust method).

Experiments are random-phase multisines, with power at chosen lines of the spectrum only:

    u(t) = sum over lines k of A_k cos(2 pi k t / N + phase)

One period has N samples, so whole periods in steady state have no leakage. n inputs need n
experiments; their phases make U(k) a multiple of a unitary matrix at each line (Dobrowiecki and
Schoukens, "Measuring a linear approximation to weakly nonlinear MIMO systems", Automatica 43,
2007): no inputs of this power determine it better.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..models.system import Complex
from ..records import as_real, as_record


def lines_between(low: float, high: float, period: int, sample_time: float) -> list[int]:
    """Lines of a period of `period` samples from `low` to `high` [Hz], ends included."""
    step = 1.0 / (period * sample_time)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    if not 1 <= first <= last <= (period - 1) // 2:
        raise ValueError(
            f"the band must hold lines k / {period * sample_time:g} s above 0 and below "
            f"{0.5 / sample_time:g} Hz, got {low:g} to {high:g} Hz"
        )
    return list(range(first, last + 1))


def orthogonal_multisines(
    period: int,
    lines: ArrayLike,
    n_inputs: int,
    rng: np.random.Generator,
    *,
    rms: ArrayLike = 1.0,
) -> Array:
    """One period of n experiments with n inputs, shape (n, period, n): experiment, time, input.

    Args:
        lines: (M,) harmonics of the period, each from 1 to below period / 2.
        rng: draws the phases; new ones are another realisation of the same power.
        rms: of each input, one value or (n,).
    """
    k, size = harmonics(lines, period), np.broadcast_to(as_real(rms, "rms"), (n_inputs,))
    if not (np.isfinite(size).all() and (size > 0.0).all()):
        raise ValueError(f"rms must be > 0, got {rms}")
    turns = np.outer(np.arange(n_inputs), np.arange(n_inputs)) / n_inputs  # input, experiment
    phases = 2 * np.pi * (rng.uniform(size=(len(k), n_inputs, 1)) + turns)
    spectrum = np.zeros((period // 2 + 1, n_inputs, n_inputs), dtype=np.complex128)
    spectrum[k] = np.exp(1j * phases) * (size * np.sqrt(0.5 / len(k)) * period)[:, None]
    return np.fft.irfft(spectrum, period, axis=0).transpose(2, 0, 1)


def harmonics(lines: ArrayLike, period: int) -> np.ndarray:
    """Lines (M,) of a period as integers; ValueError unless each is from 1 to below period / 2."""
    k = as_real(lines, "lines")
    is_line = k.ndim == 1 and k.size > 0 and np.array_equal(k, np.round(k))
    if not is_line or len(np.unique(k)) < k.size or k.min() < 1 or 2 * k.max() >= period:
        raise ValueError(
            f"lines must be different whole numbers from 1 to below {period / 2:g}, half a period"
        )
    return k.astype(np.int64)


_ROUNDING = 1e-12  # relative to the greatest line of an output: below it nothing is measured


def excess(above: Array, noise: Array, signal: Array, freedom: tuple[int, int]) -> float:
    """Mean of F-distributed ratios over its expectation, in standard deviations of that mean.

    Args:
        above, noise: variances (lines, outputs, inputs), the ratio of which is tested. Outputs
            that are known exactly, as simulated ones, have rounding for noise, and those whose
            lines are rounding alone are left out.
        signal: amplitudes (lines, outputs, inputs) that rounding is relative to.
        freedom: of numerator and denominator. 0 where the latter is too small for a variance.
    """
    d1, d2 = freedom
    rounding = np.square(_ROUNDING * signal.max(axis=(0, 2), keepdims=True))
    there = np.maximum(above, noise) > rounding
    if d2 <= 4 or not there.any():
        return 0.0
    ratio = (above / np.maximum(noise, np.maximum(rounding, np.finfo(float).tiny)))[there]
    expected, count = d2 / (d2 - 2.0), there.any(axis=1).sum()
    variance = 2.0 * d2**2 * (d1 + d2 - 2.0) / (d1 * (d2 - 2.0) ** 2 * (d2 - 4.0))
    return float((np.mean(ratio) - expected) / np.sqrt(variance / count))


def scatter(Y: np.ndarray) -> float:
    """Excess of the first period over the others, (lines, outputs, experiments, periods)."""
    n, periods = Y.shape[2:]
    if periods < 3:
        return 0.0
    rest = Y[..., 1:]
    noise = rest.var(axis=3, ddof=1).mean(axis=2, keepdims=True) * (1.0 + 1.0 / (periods - 1))
    first = np.square(np.abs(Y[..., 0] - rest.mean(axis=3)))
    return excess(first, noise, np.abs(Y).max(axis=3), (2, 2 * n * (periods - 2)))


class PeriodicRecord(NamedTuple):
    """One experiment: input (N, n) and output (N, p), N a whole number of periods."""

    u: ArrayLike
    y: ArrayLike


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Responses (M, p, n) at omega (M,) [rad/sample], and their variances E |G - estimate|^2."""

    omega: Array
    response: Complex
    noise_variance: Array
    """(M, p, n), of the noise alone, from the periods."""
    noise_freedom: int
    """Complex degrees of freedom of that estimate."""
    total_variance: Array | None
    """(M, p, n), noise and nonlinear distortion, from the realisations; None for one of them."""
    realisations: int
    start_excess: float
    """Excess of the first period over the noise, in standard deviations."""

    @property
    def variance(self) -> Array:
        """(M, p, n), the one that intervals are built from."""
        return self.noise_variance if self.total_variance is None else self.total_variance

    @property
    def freedom(self) -> int:
        """Complex degrees of freedom of `variance`."""
        return self.noise_freedom if self.total_variance is None else self.realisations - 1

    def radius(self, confidence: float = 0.95) -> Array:
        """(M, p, n), radius of the disc about each response that holds the true one.

        |error|^2 / variance is F-distributed with 2 and twice `freedom` degrees of freedom.
        """
        nu = self.freedom
        return np.sqrt(nu * ((1.0 - confidence) ** (-1.0 / nu) - 1.0) * self.variance)

    @property
    def distortion_excess(self) -> float:
        """Excess of the variance between realisations over the noise, in standard deviations."""
        if self.total_variance is None:
            return 0.0
        freedom = 2 * (self.realisations - 1), 2 * self.noise_freedom
        return excess(self.total_variance, self.noise_variance, np.abs(self.response), freedom)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to believe the response or its noise variance."""
        found = []
        if self.start_excess > _EXCESS:
            found.append(
                "the first period differs from the others by more than the noise: the start has "
                "not died out, omit more periods"
            )
        if self.distortion_excess > _EXCESS:
            found.append(
                "responses differ between realisations by more than the noise: the system is not "
                "linear, and the response depends on the power of the input"
            )
        return tuple(found)


_EXCESS = 4.0  # standard deviations: of independent lines one set in 30,000
_SINGULAR = 1e-9  # least singular value of U relative to the greatest


def frequency_response(
    realisations: Sequence[Sequence[PeriodicRecord]],
    period: int,
    lines: ArrayLike,
    *,
    omitted: int = 1,
) -> FrequencyResponse:
    """Response at the lines of `period` samples, from n experiments a realisation of n inputs.

    Args:
        realisations: for each realisation its n experiments, as of `orthogonal_multisines`.
        lines: (M,) harmonics of the period that are excited, each from 1 to below period / 2.
        omitted: periods at the start of each experiment that are not used.
    """
    k = harmonics(lines, period)
    each = [_spectra(experiments, period, k, omitted) for experiments in realisations]
    if not each:
        raise ValueError("realisations must not be empty")
    if len({(one.U.shape, one.Y.shape) for one in each}) > 1:
        raise ValueError("realisations must have the same experiments and periods")
    found = [_response(one) for one in each]
    G, noise = (np.array(part) for part in zip(*found, strict=True))
    R, (_, n, periods) = len(each), each[0].Y.shape[1:]
    total = np.var(G, axis=0, ddof=1) / R if R > 1 else None
    start = float(np.mean([scatter(one.Y) for one in each]) * np.sqrt(R))
    return FrequencyResponse(
        2 * np.pi * k / period, G.mean(axis=0), noise.mean(axis=0) / R, R * n * (periods - 1),
        total, R, start,
    )  # fmt: skip


class _Spectra(NamedTuple):
    U: Complex
    """(M, n, n), inputs by experiments."""
    Y: Complex
    """(M, p, n, P), outputs by experiments by periods."""


def _spectra(
    experiments: Sequence[PeriodicRecord], period: int, k: np.ndarray, omitted: int
) -> _Spectra:
    records = [(as_record(u, "u"), as_record(y, "y")) for u, y in experiments]
    n = records[0][0].shape[1] if records else 0
    if len(records) != n or any(u.shape[1] != n for u, _ in records):
        raise ValueError(f"{n} inputs need {n} experiments in each realisation, got {len(records)}")
    for u, y in records:
        if len(u) != len(y) or len(u) % period:
            raise ValueError(
                f"records must be whole periods of {period} samples, got {len(u)} and {len(y)}"
            )
        if len(u) // period - omitted < 2:
            raise ValueError(f"two periods must remain, got {len(u) // period - omitted}")
    U, Y = (_at_lines([pair[i] for pair in records], period, k, omitted) for i in (0, 1))
    return _Spectra(U.mean(axis=3), Y)


def _at_lines(signals: Sequence[Array], period: int, k: np.ndarray, omitted: int) -> Complex:
    """(M, columns, experiments, periods)."""
    folded = [s.reshape(-1, period, s.shape[1])[omitted:] for s in signals]
    return np.fft.rfft(np.array(folded), axis=2)[:, :, k].transpose(2, 3, 0, 1)


def _response(one: _Spectra) -> tuple[Complex, Array]:
    """G (M, p, n) and its noise variance, by the covariance of the mean over periods."""
    singular = np.linalg.svd(one.U, compute_uv=False)
    if not (singular[:, -1] > _SINGULAR * singular[:, 0]).all():
        raise ValueError("the experiments do not excite all inputs at each line")
    inverse, periods = np.linalg.inv(one.U), one.Y.shape[3]
    noise = one.Y.var(axis=3, ddof=1).mean(axis=2) / periods
    return one.Y.mean(axis=3) @ inverse, noise[:, :, None] * np.square(np.abs(inverse)).sum(1)[
        :, None
    ]
