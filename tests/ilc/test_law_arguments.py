"""Design variables of laws that are refused by name."""

from dataclasses import dataclass

import numpy as np
import pytest

from armside.ilc.laws.first_order import Blend, DType, MatrixGain, PType
from armside.ilc.laws.memory import Adaptive, HighOrder, internal_model, periodic_pattern
from armside.ilc.laws.model_free import MeasuredGradient, b_splines
from armside.ilc.laws.wrappers import Scheduled
from armside.ilc.models.linear_plant import Alternating, LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

from .signals import bump

T_S = 0.004
ARX = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], T_S)


@dataclass(frozen=True)
class Invalid:
    build: object
    message: str


@pytest.mark.parametrize(
    "case",
    [
        Invalid(lambda: DType(gamma_d=np.nan, sample_time=T_S), "gamma_d must be finite"),
        Invalid(lambda: MatrixGain(gamma=np.ones((2, 3))), r"finite \(n, n\) matrix"),
        Invalid(lambda: HighOrder(alpha=(1,), beta=(1, 2), L=PType()), "equally many"),
        Invalid(lambda: internal_model((1.0,), L=PType()), r"pattern must be \(1, d_1"),
        Invalid(lambda: internal_model((1, 0, -1), L=PType(), pole=1.0), "pole must be in"),
        Invalid(lambda: periodic_pattern(0), "period must be >= 1"),
        Invalid(
            lambda: Adaptive(L=PType(), noise_variance=0, initial_variance=1), "noise_variance"
        ),
        Invalid(lambda: Scheduled(laws=()), "at least one law"),
        Invalid(lambda: Blend(filters=(PType(),), weights=np.ones((5, 2))), r"shape \(N, 1\)"),
        Invalid(lambda: MeasuredGradient(experiment=len, size=0.0), "size must be > 0"),
        Invalid(lambda: LinearPlant(T_u=ARX, reference=bump(), noise=1.0), "needs an rng"),
        Invalid(lambda: SystemMatrix(((ARX,), (ARX, ARX))), "square matrix"),
        Invalid(lambda: System.from_z([1, 0, 0], [1, 0.5], T_S), "numerator degree 2 in q"),
        Invalid(lambda: System([1], [0, 1], T_S), "not causal"),
        Invalid(lambda: Alternating([]), "at least one plant"),
        Invalid(lambda: b_splines(10, 3), r"n_basis must be in 4\.\.10"),
    ],
)
def test_invalid_design_variables_are_refused_by_name(case):
    with pytest.raises(ValueError, match=case.message):
        case.build()
