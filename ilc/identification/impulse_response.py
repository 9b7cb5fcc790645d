"""Impulse response from short records, with its uncertainty: kernel-based least squares.

    y = G u + v,   g ~ N(0, c K),   K_ij = lambda^max(i, j)

Stable impulse responses are smooth and decay; the kernel K says so and nothing else. Its size c,
its rate lambda and the variance of v are those of the largest evidence, so that nothing is left to
choose. After Chen, Ohlsson and Ljung, "On the estimation of transfer functions, regularizations and
Gaussian processes - revisited" (Automatica 48, 2012), kernel TC.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from armside.arrays import Array

from ..records import records
from .polynomial import delayed

DECAYS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.96, 0.98)
"""lambda that are tried."""
_RATIOS = np.exp(np.linspace(-4.0, 18.0, 34))  # c over the noise, for inputs of unit power
_ROUNDING = 1e-14


class Sums(NamedTuple):
    """Normal equations of records with n taps: all that an estimate needs of them."""

    normal: Array
    """(n, n), U^T U."""
    right: Array
    """(n,), U^T y."""
    power: float
    """y^T y."""
    n_samples: int
    """Samples."""

    @classmethod
    def none(cls, n_taps: int) -> "Sums":
        return cls(np.zeros((n_taps, n_taps)), np.zeros(n_taps), 0.0, 0)

    @records("input", "output")
    def with_records(self, input: Array, output: Array) -> "Sums":
        """Sums with the columns of further records (N, m), at rest before their first sample."""
        normal, right = self.normal.copy(), self.right.copy()
        for u, y in zip(input.T, output.T, strict=True):
            U = np.stack([delayed(u[:, None], i)[:, 0] for i in range(len(right))], axis=1)
            normal += U.T @ U
            right += U.T @ y
        power = self.power + float(np.vdot(output, output))
        return Sums(normal, right, power, self.n_samples + output.size)


@dataclass(frozen=True, eq=False)
class ImpulseEstimate:
    """Estimate and its covariance, for v that is white."""

    taps: Array
    """(n,), g_0 .. g_{n-1}."""
    covariance: Array
    """(n, n)."""
    decay: float
    """lambda."""

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Output (N, m) of an input (N, m), from rest."""
        moved = [np.convolve(column, self.taps)[: len(signal)] for column in signal.T]
        return np.stack(moved, axis=1)


def impulse_response(sums: Sums) -> ImpulseEstimate:
    """Estimate of the largest evidence. ValueError for records without input or output."""
    n = len(sums.right)
    size = float(np.trace(sums.normal)) / n
    if not (size > 0.0 and sums.power > 0.0):
        raise ValueError("the impulse response needs records whose input and output are not zero")
    later = np.maximum.outer(np.arange(1, n + 1), np.arange(1, n + 1))
    best, largest = None, -np.inf
    for decay in DECAYS:
        factor = np.linalg.cholesky(decay**later + 1e-12 * np.eye(n))
        w, V = np.linalg.eigh(factor.T @ sums.normal @ factor)
        w, z = np.maximum(w, 0.0), V.T @ (factor.T @ sums.right)
        ratios = _RATIOS / size
        seen = ratios[:, None] * w
        explained = (ratios[:, None] * np.square(z) / (1.0 + seen)).sum(axis=1)
        variance = np.maximum(sums.power - explained, _ROUNDING * sums.power) / sums.n_samples
        evidence = -0.5 * (sums.n_samples * np.log(variance) + np.log1p(seen).sum(axis=1))
        i = int(np.argmax(evidence))
        if evidence[i] > largest:
            largest, shrunk = float(evidence[i]), ratios[i] / (1.0 + seen[i])
            best = decay, factor @ V, z, shrunk, float(variance[i])
    assert best is not None
    decay, basis, z, shrunk, variance = best
    return ImpulseEstimate(basis @ (shrunk * z), variance * (basis * shrunk) @ basis.T, decay)


@records("residual")
def correlation_time(residual: Array) -> float:
    """Samples (N, m) that say as much as one independent sample does: 1 + 2 sum of correlations.

    Summed to the first that is not positive.
    """
    n, power = len(residual), float(np.vdot(residual, residual))
    if power == 0.0:
        return 1.0
    spectrum = np.square(np.abs(np.fft.rfft(residual, 2 * n, axis=0))).sum(axis=1)
    rho = np.fft.irfft(spectrum, 2 * n)[:n] / power
    end = int(np.argmax(rho <= 0.0)) or n
    return float(1.0 + 2.0 * rho[1:end].sum())
