"""The work that makes the theory quick; `armside bench ilc` has the seconds."""

import numpy as np
import pytest

from armside.ilc.analysis import largest_gamma
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import TwoMassLoop


@pytest.mark.parametrize("n_shifts", [1, 50])
def test_a_search_over_shifts_and_cutoffs_evaluates_the_model_once(monkeypatch, n_shifts):
    calls = []
    response = System.response
    monkeypatch.setattr(System, "response", lambda *args: calls.append(1) or response(*args))
    bounds = largest_gamma(TwoMassLoop().T_arm, np.arange(n_shifts), [5.0, 10.0, 20.0])
    assert bounds.shape == (n_shifts, 3)
    assert len(calls) == 1


def test_norm_optimal_for_six_motors_grows_with_the_record_and_not_with_its_square():
    servo = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], 0.004)
    slower = TwoMassLoop(sample_time=0.004).T_motor
    T_u = SystemMatrix.diagonal([servo, slower] * 3)

    def entries(n_samples: int) -> int:
        return NormOptimal(T_u=T_u, n_samples=n_samples, n_columns=6)._solver._lu.nnz

    assert entries(400) == pytest.approx(2 * entries(200), rel=0.1)
