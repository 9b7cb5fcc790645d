"""Interface of a learning law, and the general first-order law u_{k+1} = Q(u_k + L e_k)."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from armside.arrays import Array

from ..filters import ALL_PASS, RecordFilter
from ..records import records


class Law(Protocol):
    """Learning law: (u_k, e_k, memory) to (u_{k+1}, memory). It holds design variables only."""

    def step(self, correction: Array, error: Array, memory: Any = None, /) -> tuple[Array, Any]:
        """u_{k+1} and the next memory from u_k, e_k, shape (N, n), and the memory (first: None)."""
        ...

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError if the law does not fit records of shape (N, n)."""
        ...


class FirstOrderLaw:
    """Base of laws without memory: `__call__(u_k, e_k)` returns u_{k+1}."""

    def __call__(self, correction: Array, error: Array, /) -> Array:
        raise NotImplementedError

    @records("correction", "error", alike=False)
    def step(self, correction: Array, error: Array, memory: None = None, /) -> tuple[Array, None]:
        return self(correction, error), None

    def check(self, n_samples: int, n_columns: int) -> None:
        """Accept records of every shape, unless a law overrides this."""


def require_linear(law: Any) -> None:
    """Raise ValueError for a law whose iteration is no linear map: with memory, or with limits."""
    name = type(law).__name__
    if not callable(law):
        raise ValueError(f"{name} has a memory: the analysis is that of laws without one")
    if np.isfinite(getattr(law, "limit", np.inf)).any():
        raise ValueError(f"{name} has limits, so it is not linear: analyse it with limit=inf")


@dataclass(frozen=True, kw_only=True)
class FilteredLaw:
    """Filters of a law: L of the error, an inverse of T_u or an approximation, and Q."""

    L: RecordFilter
    Q: RecordFilter = ALL_PASS

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError if a filter does not fit records of shape (N, n)."""
        self.L.check(n_samples, n_columns)
        self.Q.check(n_samples, n_columns)


@dataclass(frozen=True, kw_only=True)
class FirstOrder(FilteredLaw, FirstOrderLaw):
    """u_{k+1} = Q(u_k + L e_k). Thesis (7.2)."""

    @records("correction", "error", alike=False)
    def __call__(self, correction: Array, error: Array, /) -> Array:
        learned = self.L(error)
        if learned.shape != correction.shape:
            shapes = f"{learned.shape} and {correction.shape}"
            raise ValueError(f"L e and the correction must have one shape, got {shapes}")
        return self.Q(correction + learned)
