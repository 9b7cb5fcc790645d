"""Largest singular value of a linear map of records, from products alone."""

from typing import Any

import numpy as np

from armside.arrays import Array

from .state_space import RecordModel

_TIGHT = 1e-10  # relative residual of a singular value
_TINY = 3  # sizes up to which the matrix is built, too small for Lanczos
_SMALL = 300  # sizes up to which it is built where Lanczos iterations do not converge
_RESTARTS = 100
_ADJOINT = 1e-6  # relative difference of inner products by rounding


def dense(model: RecordModel, n_samples: int) -> Array:
    """Matrix (N p, N m) of records laid out sample by sample."""
    size = n_samples * model.n_inputs
    units = np.eye(size).reshape(size, n_samples, -1)
    return np.stack([model.simulate(unit).ravel() for unit in units], axis=1)


def require_adjoint(model: RecordModel, n_samples: int) -> Array:
    """T u of a random record. Raises ValueError unless <T u, e> = <u, T^T e>."""
    rng = np.random.default_rng(0)
    u, e = (rng.standard_normal((n_samples, n)) for n in (model.n_inputs, model.n_outputs))
    forward, backward = model.simulate(u), model.adjoint(e)
    norm = np.linalg.norm
    apart = abs(float(np.vdot(forward, e) - np.vdot(u, backward)))
    size = float(norm(forward) * norm(e) + norm(u) * norm(backward))
    if not apart <= _ADJOINT * size:
        raise ValueError(
            "simulate and adjoint do not belong to one linear map: <T u, e> and <u, T^T e> differ "
            f"by {apart / size:.2g} of their size"
        )
    return forward


def largest_singular_value(model: RecordModel, n_samples: int) -> float:
    """2-norm of y = T u over records of n_samples, by Lanczos iterations on T and its adjoint.

    From below: the residual of the vector found is below 1e-10 of the value, so a singular value
    lies that close; the random start makes it the largest one. Where many lie as close together
    the residual of the squared map is taken, and then a RuntimeError raised. ValueError for an
    adjoint that is none.
    """
    if not require_adjoint(model, n_samples).any():  # nor is any other vector mapped
        return 0.0
    size = n_samples * min(model.n_inputs, model.n_outputs)
    if size > _TINY and (found := _by_lanczos(model, n_samples, _TIGHT)) is not None:
        return found
    if size <= _SMALL:
        return float(np.linalg.norm(dense(model, n_samples), ord=2))
    if (found := _by_lanczos(model, n_samples, np.sqrt(_TIGHT))) is not None:  # scipy squares it
        return found
    raise RuntimeError(
        f"the largest singular value is not known to {_TIGHT:g} after {_RESTARTS} restarts: too "
        "many lie close to it"
    )


def _by_lanczos(model: RecordModel, n_samples: int, tolerance: float) -> float | None:
    from scipy.sparse.linalg import ArpackError, LinearOperator, svds

    build: Any = LinearOperator  # scipy's stubs know no keywords of it
    solve: Any = svds  # nor a tolerance that is a float
    operator = build(
        (n_samples * model.n_outputs, n_samples * model.n_inputs),
        matvec=lambda v: model.simulate(v.reshape(n_samples, -1)).ravel(),
        rmatvec=lambda v: model.adjoint(v.reshape(n_samples, -1)).ravel(),
        dtype=np.float64,
    )
    start = np.random.default_rng(0).standard_normal(min(operator.shape))
    try:
        found = solve(
            operator, k=1, tol=tolerance, v0=start, maxiter=_RESTARTS,
            return_singular_vectors=False,
        )  # fmt: skip
    except ArpackError:
        return None
    return float(found[0])
