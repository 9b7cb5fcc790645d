"""Causes of speed: work and memory that grow with the record's length, and results kept.

Seconds are measured by `armside bench ilc`.
"""

import pytest

from armside.ilc import two_mass_study
from armside.ilc.laws.norm_optimal import BandedProblem, LeastSquares, QuadraticCriterion
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import TwoMassLoop


def test_norm_optimal_learning_of_six_motors_costs_in_proportion_to_the_samples():
    servo = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], 0.004)
    T_u = SystemMatrix.diagonal([servo, TwoMassLoop(sample_time=0.004).T_motor] * 3)
    criterion = QuadraticCriterion(correction=1e-4, change=1e-2)
    problems = [BandedProblem.build(T_u, criterion, n, 6) for n in (250, 500)]
    entries = [problem.M.nnz for problem in problems]
    factors = [LeastSquares(problem.M, 6)._lu.nnz for problem in problems]
    for counted in (entries, factors):
        assert counted[1] == pytest.approx(2 * counted[0], rel=0.1)
    # A dense lower triangle of 500 samples x 6 motors would hold 4.5 million.
    assert factors[1] < 0.2 * 4.5e6


def test_500_iterations_are_run_once_for_all_figures():
    assert two_mass_study.learned(17.0) is two_mass_study.learned(17.0)
