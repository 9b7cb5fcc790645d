"""The first-order law from any two filters of finished records."""

from dataclasses import dataclass

from ..filters import ALL_PASS, RecordFilter
from ..plant import Array
from .law import FirstOrderLaw


@dataclass(frozen=True, kw_only=True)
class FirstOrder(FirstOrderLaw):
    """u_{k+1} = Q(u_k + L e_k). Thesis (7.2)."""

    L: RecordFilter
    Q: RecordFilter = ALL_PASS

    def check(self, n_samples: int, n_columns: int) -> None:
        self.L.check(n_samples, n_columns)
        self.Q.check(n_samples, n_columns)

    def __call__(self, correction: Array, error: Array, /) -> Array:
        return self.Q(correction + self.L(error))
