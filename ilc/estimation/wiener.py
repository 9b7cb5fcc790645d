"""Non-causal Wiener filter: the smoother of a stationary process in the frequency domain.

    T(w) = S_zy(w) S_yy(w)^-1

with S the spectra of the estimated z = Z x and the measured y = C x + v of x' = A x + G w. It is
exact far from the ends of a record.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..models.system import Complex
from ..records import as_measured, records


@dataclass(frozen=True, eq=False)
class NonCausal:
    """Non-causal Wiener filter from y to z = Z x of a continuous process with white noise on x'.

    Shapes: A and intensity of the noise (n, n), C (p, n), Z (q, n).
    """

    A: Array
    intensity: Array
    C: Array
    Z: Array

    def response(self, frequency: Array, sample_time: float, R: Array) -> Complex:
        """T, (M, q, p), at frequencies [Hz] below the Nyquist frequency.

        R: (p, p), covariance of v, of intensity R h in the band. y is assumed to be zero beyond
        the band, as behind an anti-aliasing filter.
        """
        # 1e-3 Hz: above the poles at 0 of slow drifts
        s = 2j * np.pi * np.maximum(np.abs(frequency), 1e-3)[:, None, None]
        states = np.linalg.inv(s * np.eye(len(self.A)) - self.A)
        spectrum = states @ self.intensity @ np.conj(np.swapaxes(states, 1, 2))
        S_yy = self.C @ spectrum @ self.C.T + R * sample_time
        S_zy = self.Z @ spectrum @ self.C.T
        return S_zy @ np.linalg.inv(S_yy)

    @records("y", gate=as_measured)
    def __call__(self, y: Array, sample_time: float, R: Array) -> Array:
        """z (N, q) from y (N, p), both zero and at rest at the ends."""
        padded = 2 * len(y)
        frequency: Array = np.asarray(np.fft.rfftfreq(padded, sample_time), dtype=np.float64)
        Y = np.fft.rfft(np.nan_to_num(y), padded, axis=0)
        T = self.response(frequency, sample_time, R)
        return np.fft.irfft((T @ Y[:, :, None])[:, :, 0], padded, axis=0)[: len(y)]
