"""Largest singular value and spectral radius of linear maps of records, from products alone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

Apply = Callable[[Array], Array]
_TIGHT = 1e-10  # relative residual of a singular or eigenvalue
_TINY = 3  # sizes up to which the matrix is built, too small for Lanczos
SMALL = 300  # sizes up to which it is built where Lanczos iterations do not converge
_RESTARTS = 100
_LARGEST = 1e150  # of a power, whose square is a number
_ADJOINT = 1e-6  # relative difference of inner products by rounding


@dataclass(frozen=True, eq=False)
class Products:
    """Linear map of records (N, m) to records (N, p), and its adjoint."""

    inputs: tuple[int, int]
    outputs: tuple[int, int]
    forward: Apply
    backward: Apply

    def power(self, k: int) -> "Products":
        """The map k times over, inputs and outputs of one shape."""

        def repeated(once: Apply) -> Apply:
            def times(signal: Array) -> Array:
                for _ in range(k):
                    signal = once(signal)
                    require_moderate(signal, k)
                return signal

            return times

        return Products(self.inputs, self.outputs, repeated(self.forward), repeated(self.backward))

    def dense(self) -> Array:
        """Matrix (N p, N m)."""
        size = int(np.prod(self.inputs))
        units = np.eye(size).reshape(size, *self.inputs)
        return np.stack([self.forward(unit).ravel() for unit in units], axis=1)

    def operator(self) -> Any:
        """LinearOperator of scipy."""
        from scipy.sparse.linalg import LinearOperator

        build: Any = LinearOperator  # scipy's stubs know no keywords of it
        return build(
            (int(np.prod(self.outputs)), int(np.prod(self.inputs))),
            matvec=lambda v: self.forward(v.reshape(self.inputs)).ravel(),
            rmatvec=lambda v: self.backward(v.reshape(self.outputs)).ravel(),
            dtype=np.float64,
        )


def largest_singular_value(products: Products, tight: float = _TIGHT, power: int = 1) -> float:
    """2-norm of the map, `power` times over, by Lanczos iterations on the map and its adjoint.

    From below: the residual of the vector found is below `tight` of the value, so a singular value
    lies that close; the random start makes it the largest one. Where many lie as close together
    the residual of the squared map is taken, and then a RuntimeError raised, as for a power that is
    lost in rounding. OverflowError for a power beyond 1e150, ValueError for a backward
    map that is not the adjoint of the forward map.
    """
    size = min(np.prod(products.inputs), np.prod(products.outputs))
    forward = _checked(products)
    if power != 1:
        products = products.power(power)
        try:
            forward = _checked(products)
        except ValueError as error:
            raise RuntimeError(
                f"power {power} of the map is lost in rounding: lower powers are far larger"
            ) from error
    if not forward.any():  # nor is any other vector mapped
        return 0.0
    if size > _TINY and (found := _by_lanczos(products, tight)) is not None:
        return found
    if size <= SMALL:
        return float(np.linalg.norm(products.dense(), ord=2))
    if (found := _by_lanczos(products, np.sqrt(tight))) is not None:  # scipy squares it
        return found
    raise RuntimeError(
        f"the largest singular value is not known to {tight:g} after {_RESTARTS} restarts: too "
        "many lie close to it"
    )


def _by_lanczos(products: Products, tolerance: float) -> float | None:
    from scipy.sparse.linalg import ArpackError, svds

    solve: Any = svds  # its stubs know no tolerance that is a float
    shape = min(products.inputs, products.outputs, key=np.prod)
    start = _start(shape).ravel()
    try:
        found = solve(
            products.operator(), k=1, tol=tolerance, v0=start, maxiter=_RESTARTS,
            return_singular_vectors=False,
        )  # fmt: skip
    except ArpackError:
        return None
    return float(found[0])


def _checked(products: Products) -> Array:
    """Of a random record, whose product with another is that of the adjoint."""
    u, v = _start(products.inputs), _start(products.outputs)[::-1]
    forward, backward = products.forward(u), products.backward(v)
    require_adjoint(u, v, forward, backward)
    return forward


def require_moderate(values: Array, power: int) -> None:
    """Raise OverflowError for values of a power of a map whose squares no number can hold."""
    if not np.abs(values).max(initial=0.0) < _LARGEST:
        raise OverflowError(f"power {power} of the map exceeds {_LARGEST:g}: it diverges")


def require_adjoint(u: Array, v: Array, forward: Array, backward: Array) -> None:
    """Raise ValueError unless <forward, v> = <u, backward>, for T u and T^T v of random records."""
    norm = np.linalg.norm
    apart = abs(float(np.vdot(forward, v) - np.vdot(u, backward)))
    size = float(norm(forward) * norm(v) + norm(u) * norm(backward))
    if not apart <= _ADJOINT * size:
        raise ValueError(
            "simulate and adjoint do not belong to one linear map: <T u, e> and <u, T^T e> differ "
            f"by {apart / size:.2g} of their size"
        )


def _start(shape: tuple[int, int]) -> Array:
    """Random record, in which no singular vector is missing."""
    return np.random.default_rng(0).standard_normal(shape)
