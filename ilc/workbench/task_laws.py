"""Laws by name that are built for one kind of task: other references, points, laps."""

from ..laws.basis_functions import BasisFunctions, derivatives
from ..laws.law import Law
from ..laws.model_inverse import ModelInverse
from ..laws.point_to_point import PointToPoint
from ..laws.rational_basis import RationalBasis
from ..laws.repetitive import Repetitive
from .setting import Setting


def basis(s: Setting, *, order: int = 4, ridge: float = 1e-9) -> Law:
    """Polynomial basis functions: derivatives 1 to `order` of the reference."""
    found = derivatives(s.reference, s.sample_time, order)
    return BasisFunctions(T_u=s.T_u("basis"), basis=found, ridge=ridge)


def rational(s: Setting, *, numerator: int = 4, denominator: int = 2) -> Law:
    """Rational basis functions: so many terms in the numerator and the denominator."""
    return RationalBasis(
        T_u=s.shared_model("rational"),
        reference=s.reference,
        n_numerator=numerator,
        n_denominator=denominator,
    )


def point_to_point(s: Setting, *, times: tuple[float, ...]) -> Law:
    """Right at these times [s] of the record and free between them: times=0.5/1.2."""
    points = [round(time / s.sample_time) for time in times]
    size = {"n_samples": s.n_samples, "n_columns": s.n_columns}
    return PointToPoint(T_u=s.T_u("point-to-point"), points=points, **size)


def repetitive(s: Setting, *, period: int, begin: int = 0, cutoff: float | None = None) -> Law:
    """Laps of `period` samples from sample `begin` on: one periodic correction for all."""
    Q = s.Q(cutoff)
    L = ModelInverse(T_u=s.T_u("repetitive"), learned=Q, regularisation=1e-6)
    return Repetitive(L=L, Q=Q, period=period, begin=begin)
