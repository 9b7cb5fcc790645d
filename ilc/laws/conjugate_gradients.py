"""Preconditioned conjugate gradients for records, with a bound on the error of the solution."""

from collections.abc import Callable

import numpy as np

from armside.arrays import Array

Apply = Callable[[Array], Array]

ACCURACY = 1e-7
"""Largest error of a solution relative to its size; one that does not reach it is an error."""
_REFINED = 1e-11  # error at which refinement ends
_FACTORED, _MATRIX_FREE = 30, 3000  # largest numbers of steps


def solve_factored(hessian: Apply, precondition: Apply, g: Array) -> tuple[Array, float]:
    """(d, error): H d = g by a preconditioner that is nearly the inverse of H.

    error: estimate of |d - H^-1 g| / |d|, the size of one more correction.
    """
    d, r = np.zeros_like(g), g
    z = p = precondition(r)
    size, estimate = float(np.vdot(r, z)), np.inf
    if size == 0.0:
        return d, 0.0
    for _ in range(_FACTORED):
        d, r, z, size, before = _step(hessian, precondition, d, r, p, size)
        last, estimate = estimate, float(np.linalg.norm(z) / np.linalg.norm(d))
        if estimate <= _REFINED or not size > 0.0 or estimate > 0.5 * last:
            break
        p = z + size / before * p
    return d, estimate


def solve_matrix_free(hessian: Apply, R: Array, g: Array) -> tuple[Array, float]:
    """(d, error): H d = g for H >= diag(R) > 0, of which only products are known.

    error: bound of |d - H^-1 g| / |d| in the norm of R, for r^T H^-1 r <= r^T R^-1 r.
    """
    d, r = np.zeros_like(g), g
    z = p = r / R
    size, estimate = float(np.vdot(r, z)), np.inf
    if size == 0.0:
        return d, 0.0
    for _ in range(_MATRIX_FREE):
        d, r, z, size, before = _step(hessian, lambda r: r / R, d, r, p, size)
        estimate = float(np.sqrt(size / np.vdot(d, R * d)))
        if estimate <= 0.01 * ACCURACY or not size > 0.0:
            break
        p = z + size / before * p
    r = g - hessian(d)  # of the solution itself: the updated one drifts by rounding
    return d, max(estimate, float(np.sqrt(np.vdot(r, r / R) / np.vdot(d, R * d))))


def _step(
    hessian: Apply, precondition: Apply, d: Array, r: Array, p: Array, size: float
) -> tuple[Array, Array, Array, float, float]:
    """d, r, z = precondition(r) and r^T z after a step along p, and r^T z before."""
    Hp = hessian(p)
    along = size / float(np.vdot(p, Hp))
    d, r = d + along * p, r - along * Hp
    z = precondition(r)
    return d, r, z, float(np.vdot(r, z)), size
