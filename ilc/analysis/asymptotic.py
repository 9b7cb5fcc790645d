"""Asymptotic error of learning in the frequency domain. Thesis (7.7), (8.17)."""

import numpy as np

from armside.arrays import Array

from ..filters import RecordFilter
from ..models.system import Complex, require_stable
from ..models.system_matrix import Model
from ..records import records


@records("first_error")
def asymptotic_error(
    first_error: Array, T_u: Model, L: RecordFilter, Q: RecordFilter, n_padding: int = 0
) -> Array:
    """e_inf of u_{k+1} = Q(u_k + L e_k), shape (N, n), from e_0, the error without correction.

    E_inf = (1 - Q) E_0 / (1 - Q (1 - T_u L)); for coupled motors E_inf = E_0 - T_u U_inf with
    (I - Q (I - L T_u)) U_inf = Q L E_0. A repeating load w is part of e_0 = e - T_w w.
    The record is treated as one period; n_padding zeros after it represent a record that begins
    and ends at rest.

    Raises:
        ValueError: for an unstable T_u, a Q whose cutoffs are not as many as the columns, or if the
            denominator vanishes at a frequency, which then has no limit, at which some correction
            is neither learned nor forgotten.
    """
    n_samples = len(first_error)
    length = n_samples + n_padding
    require_stable(T_u, "T_u")
    omega = 2.0 * np.pi * np.fft.rfftfreq(length)
    E = np.fft.rfft(first_error, length, axis=0)
    T, L_response, q = T_u.response(omega), L.response(omega), Q.response(omega)
    if T.ndim == 1 and L_response.ndim == 3:
        T = T[:, None, None] * np.eye(L_response.shape[2])
    if T.ndim == 3:
        limit = _coupled(E, T, _as_matrices(L_response, T), _as_matrices(q, T))
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


def _as_matrices(response: Array | Complex, T: Complex) -> Complex:
    """Response of shape (M,), of each motor (M, n), or (M, n, n), as the last."""
    identity = np.eye(T.shape[2])
    if response.ndim == 3:
        return response.astype(np.complex128)
    columns = response[:, None] if response.ndim == 1 else response
    return (columns[:, :, None] * identity).astype(np.complex128)


def _require_limit(smallest: float) -> None:
    if smallest < 1e-12:
        raise ValueError("no asymptotic error: Q (1 - T_u L) is 1 at some frequency")
