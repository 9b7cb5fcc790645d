"""Non-causal Wiener filter: the smoother of a stationary process in the frequency domain.

    T(w) = S_zy(w) S_yy(w)^-1

with S the spectra of the estimated z = Z x and the measured y = C x + v of x' = A x + G w. It is
exact far from the ends of a record.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.models.system import Complex


@dataclass(frozen=True, eq=False)
class NonCausal:
    """Non-causal Wiener filter from y to z = Z x of a continuous process with white noise on x'.

    Shapes: A and intensity of the noise (n, n), C (p, n), Z (q, n).
    """

    A: Array
    intensity: Array
    C: Array
    Z: Array

    def _spectra(self, frequency: Array, sample_time: float, R: Array) -> tuple[Complex, Complex]:
        # 1e-3 Hz: above the poles at 0 of slow drifts
        s = 2j * np.pi * np.maximum(np.abs(frequency), 1e-3)[:, None, None]
        states = np.linalg.inv(s * np.eye(len(self.A)) - self.A)
        spectrum = states @ self.intensity @ np.conj(np.swapaxes(states, 1, 2))
        S_yy = self.C @ spectrum @ self.C.T + R * sample_time
        return self.Z @ spectrum @ self.C.T, S_yy

    def __call__(self, y: Array, sample_time: float, R: Array) -> Array:
        """z (N, q) from y (N, p), both zero and at rest at the ends; NaN marks what is missing."""
        padded = 2 * len(y)
        frequency: Array = np.asarray(np.fft.rfftfreq(padded, sample_time), dtype=np.float64)
        S_zy, S_yy = self._spectra(frequency, sample_time, R)
        precision: Complex = np.asarray(np.linalg.inv(S_yy), dtype=np.complex128)
        if np.isnan(y).any():
            y = _completed(y, lambda record: _filtered(precision, record))
        return _filtered(S_zy @ precision, y)


def _filtered(T: Complex, y: Array) -> Array:
    """T (M, q, p) on a record (N, p), with as many zeros after it."""
    padded = 2 * len(y)
    Y = np.fft.rfft(y, padded, axis=0)
    return np.fft.irfft((T @ Y[:, :, None])[:, :, 0], padded, axis=0)[: len(y)]


def _completed(y: Array, precision: Callable[[Array], Array]) -> Array:
    """y with the expected values of what is missing: those to which the precision gives no weight.

    Conjugate gradients. Raises RuntimeError if they do not converge.
    """
    from scipy.sparse.linalg import LinearOperator, cg

    missing = np.isnan(y)
    whole = np.where(missing, 0.0, y)

    def product(values: Array) -> Array:
        record = np.zeros_like(y)
        record[missing] = np.ravel(values)
        return precision(record)[missing]

    n = int(missing.sum())
    operator = LinearOperator((n, n), matvec=product, dtype=np.float64)  # pyright: ignore[reportCallIssue]
    found, failed = cg(operator, -precision(whole)[missing], rtol=1e-9, maxiter=10 * n + 100)
    if failed:
        raise RuntimeError(f"{n} missing readings could not be filled: leave out the channel")
    whole[missing] = found
    return whole
