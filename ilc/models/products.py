"""Largest singular value and spectral radius of linear maps of records, from products alone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from armside.arrays import Array

Apply = Callable[[Array], Array]
_TIGHT = 1e-10  # relative residual of a singular or eigenvalue
_SMALL = 3  # sizes up to which the matrix is built, too small for Lanczos


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


def largest_singular_value(products: Products, tight: float = _TIGHT) -> float:
    """2-norm of the map, by Lanczos iterations on the map and its adjoint.

    From below: the residual of the vector found is below `tight` of the value, so a singular value
    lies that close; the random start makes it the largest one.
    """
    from scipy.sparse.linalg import svds

    if min(np.prod(products.inputs), np.prod(products.outputs)) <= _SMALL:
        return float(np.linalg.norm(products.dense(), ord=2))
    solve: Any = svds  # its stubs know no tolerance that is a float
    shape = min(products.inputs, products.outputs, key=np.prod)
    start = np.random.default_rng(0).standard_normal(int(np.prod(shape)))
    found = solve(products.operator(), k=1, tol=tight, v0=start, return_singular_vectors=False)
    return float(found[0])
