"""Linear plant of thesis chapter 7."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import NamedTuple

import numpy as np

from armside.arrays import Array, check_numbers

from ..records import as_record, records
from .system import System
from .system_matrix import AnyModel, check_model


class Variables(NamedTuple):
    """Outputs of one iteration, (N, n) each."""

    controlled: Array
    """z_k, free of measurement noise."""
    measured: Array
    """y_k."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearPlant:
    """z_k = T_r r + T_u (u_k + C e_k) + T_w w_k, y_k = z_k + T_v v_k. Thesis (7.1), Fig 7.1.

    `run` returns y_k, shape (N, n), and `variables` both z_k and y_k. e_k = r - y_k reaches the
    input in the same iteration through C, the direct term of (7.4), which is feedback beside the
    learning.
    """

    T_u: AnyModel
    """Time-invariant, or along the record of the reference."""
    reference: Array
    """r, shape (N, n)."""
    T_r: AnyModel | None = None
    """None: T_u, the correction is added to the reference."""
    T_w: AnyModel | None = None
    T_v: AnyModel | None = None
    """Load and noise to output; None: they add to the output."""
    loads: Sequence[Array] = ()
    """w_k, shape (N, n), cyclic over the iterations: one repeats, two alternate."""
    noise: float = 0.0
    """Standard deviation of v."""
    rng: np.random.Generator | None = None
    """Source of v; needed if there is noise."""
    C: System | None = None
    """Direct term: acts on each column's own error. Needs one system as T_u."""
    _loop: System | None = field(init=False, repr=False)
    _iteration: count = field(init=False, repr=False, default_factory=count)

    def __post_init__(self) -> None:
        check_model(self.T_u)
        reference = as_record(self.reference, "reference")
        object.__setattr__(self, "reference", reference)
        object.__setattr__(self, "loads", tuple(as_record(w, "loads") for w in self.loads))
        for load in self.loads:
            if load.shape != reference.shape:
                raise ValueError(f"loads must have shape {reference.shape}, got {load.shape}")
        check_numbers(self, "noise")
        if self.noise < 0.0 or (self.noise > 0.0 and self.rng is None):
            needed = ">= 0 and needs an rng if it is not 0"
            raise ValueError(f"noise must be {needed}, got {self.noise}")
        loop = None
        if self.C is not None:
            if not isinstance(self.T_u, System):
                raise ValueError("a direct term C needs a T_u with one input and one output")
            loop = (self.T_u * self.C).feedback("the loop of T_u and the direct term C")
        object.__setattr__(self, "_loop", loop)

    @records("correction")
    def run(self, correction: Array, /) -> Array:
        return self.variables(correction).measured

    @records("correction")
    def variables(self, correction: Array, /) -> Variables:
        """z_k and y_k of the next iteration; `run` likewise goes on to the next."""
        k = next(self._iteration)
        z = (self.T_r or self.T_u).simulate(self.reference) + self.T_u.simulate(correction)
        if self.loads:
            z = z + _through(self.T_w, self.loads[k % len(self.loads)])
        y = z
        if self.noise > 0.0 and self.rng is not None:
            y = z + _through(self.T_v, self.rng.normal(0.0, self.noise, z.shape))
        if self._loop is not None:  # both with T_u C e, e = (r - y without it) / (1 + T_u C)
            fed_back = self._loop.simulate(self.reference - y)
            z, y = z + fed_back, y + fed_back
        return Variables(z, y)


def _through(system: AnyModel | None, signal: Array) -> Array:
    return signal if system is None else system.simulate(signal)
