"""Heuristic law of the thesis's experiments: Q(u + gamma q^delta e), Algorithm 1."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array, check_numbers

from ..filters import End, PerColumn, RecordFilter, as_tuple, check_columns, check_shift, shift
from ..records import records
from .first_order import FirstOrderLaw


@dataclass(frozen=True, kw_only=True)
class Heuristic(FirstOrderLaw):
    """u_{k+1} = Q(u_k + gamma q^delta e_k). Thesis (8.12), (9.1), (9.2).

    gamma and delta (and the cutoff inside Q) are one value for all motors or one for each.
    """

    Q: RecordFilter
    gamma: PerColumn = 0.9
    """Learning gain, > 0."""
    delta: int | tuple[int, ...] = 0
    """Time shift [samples]; > 0 looks ahead."""
    end: End = End.HOLD
    """Samples moved in at the end of the record; zeros leave a slow mode there."""

    def __post_init__(self) -> None:
        check_numbers(self, "gamma", "delta", several=True, nan=True)
        for name in ("gamma", "delta"):
            if np.ndim(getattr(self, name)) == 1:
                object.__setattr__(self, name, tuple(getattr(self, name)))
        for gamma in as_tuple(self.gamma):
            if not (np.isfinite(gamma) and gamma > 0.0):
                raise ValueError(f"gamma must be > 0 and finite, got {gamma}")
        for delta in as_tuple(self.delta):
            if not np.isfinite(delta) or delta != int(delta):
                raise ValueError(f"delta must be a whole number of samples, got {delta}")
        whole = tuple(int(delta) for delta in as_tuple(self.delta))
        object.__setattr__(self, "delta", whole if isinstance(self.delta, tuple) else whole[0])

    def check(self, n_samples: int, n_columns: int) -> None:
        """Raise ValueError for a shift, or a number of values, that does not fit the records."""
        check_columns("gamma", self.gamma, n_columns)
        check_columns("delta", self.delta, n_columns)
        check_shift(self.delta, n_samples)
        self.Q.check(n_samples, n_columns)

    @records("correction", "error")
    def __call__(self, correction: Array, error: Array, /) -> Array:
        check_columns("gamma", self.gamma, error.shape[1])
        learned = self.Q(correction + np.asarray(self.gamma) * shift(error, self.delta, self.end))
        if np.shape(learned) != correction.shape:
            raise ValueError(f"Q must return the shape {correction.shape}, got {np.shape(learned)}")
        return learned
