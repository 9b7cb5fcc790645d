"""State-space model that varies along the record, such as a robot linearised along its path.

x(t + 1) = A(t) x(t) + B(t) u(t)        y(t) = C(t) x(t) + D(t) u(t)        x(0) = 0
"""

from dataclasses import dataclass
from functools import cached_property

from armside.arrays import Array

from ..records import records
from .blocks import Realisation, filtered
from .record_model import check_shape
from .state_space import matrices


@dataclass(frozen=True, eq=False)
class TimeVarying:
    """Matrices of each sample: A (N, n, n), B (N, n, m), C (N, p, n), D (N, p, m) or None for 0."""

    A: Array
    B: Array
    C: Array
    D: Array | None = None

    def __post_init__(self) -> None:
        for name, M in zip(
            "ABCD", matrices(self.A, self.B, self.C, self.D, dimensions=3), strict=True
        ):
            M.setflags(write=False)
            object.__setattr__(self, name, M)

    @property
    def n_samples(self) -> int:
        return len(self.A)

    @property
    def n_inputs(self) -> int:
        return self.B.shape[2]

    @property
    def n_outputs(self) -> int:
        return self.C.shape[1]

    @cached_property
    def realisation(self) -> Realisation:
        assert self.D is not None
        return Realisation.of(self.A, self.B, self.C, self.D)

    def filtered_realisation(self, taps: Array) -> Realisation:
        """Of F T, F the finite impulse response `taps`."""
        assert self.D is not None
        return Realisation.of(*filtered(self.A, self.B, self.C, self.D, taps))

    @records("signal")
    def simulate(self, signal: Array) -> Array:
        """Outputs (N, p) for inputs (N, m), from zero state."""
        check_shape(self, signal.shape, self.n_inputs, "inputs")
        return self.realisation.simulate(signal)

    @records("signal")
    def adjoint(self, signal: Array) -> Array:
        """T^T e, shape (N, m), for e (N, p)."""
        check_shape(self, signal.shape, self.n_outputs, "outputs")
        return self.realisation.adjoint(signal)
