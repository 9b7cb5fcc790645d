"""Algorithm 2: L = T_u^-1 (1 - H_B), the inverse of a model with a desired convergence rate."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import Complex, require_stable
from ..models.system_matrix import Model, check_inputs, require_effect
from ..records import records

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
            self._require_inverse(power == 0.0, learned)
            return learned * T.conj() / np.where(power == 0.0, 1.0, power)
        learned = learned if learned.ndim == 2 else learned[:, None]
        U, s, V_H = np.linalg.svd(T, full_matrices=False)
        if self._rho == 0.0:
            self._require_inverse(s[:, -1] <= _SINGULAR * s[:, 0], learned.max(axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = np.nan_to_num(s / (np.square(s) + self._rho), nan=0.0, posinf=0.0)
        inverse = (V_H.conj().swapaxes(1, 2) * gain[:, None, :]) @ U.conj().swapaxes(1, 2)
        return (inverse * learned[:, None, :]).astype(np.complex128)

    def _require_inverse(self, singular: NDArray[np.bool_], learned: Array) -> None:
        if (singular & (np.abs(learned) > _LEARNED)).any():
            raise ValueError(
                "T_u has no inverse at a frequency that is learned: regularisation > 0"
            )

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
