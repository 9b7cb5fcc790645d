"""Asymptotic error of learning in the frequency domain. Thesis (7.7), (8.17)."""

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import System
from ..records import records


@records("first_error")
def asymptotic_error(
    first_error: Array, T_u: System, L: RecordFilter, Q: RecordFilter, n_padding: int = 0
) -> Array:
    """e_inf of u_{k+1} = Q(u_k + L e_k), shape (N, n), from e_0, the error without correction.

    E_inf = (1 - Q) E_0 / (1 - Q (1 - T_u L)). A repeating load w is part of e_0 = e - T_w w.
    The record is treated as one period; n_padding zeros after it represent a record that begins
    and ends at rest.

    Raises:
        ValueError: if the denominator vanishes at a frequency, which then has no limit.
    """
    n_samples = len(first_error)
    length = n_samples + n_padding
    omega = 2.0 * np.pi * np.fft.rfftfreq(length)
    q = Q.response(omega)
    denominator = 1.0 - q * (1.0 - T_u.response(omega) * L.response(omega))
    if np.abs(denominator).min() < 1e-12:
        raise ValueError("no asymptotic error: Q (1 - T_u L) is 1 at some frequency")
    spectrum = np.fft.rfft(first_error, length, axis=0)
    ratio = (1.0 - q) / denominator
    return np.fft.irfft(ratio[:, None] * spectrum, length, axis=0)[:n_samples]
