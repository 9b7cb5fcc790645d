"""Resonances narrower than a fixed grid are found by every analysis that searches frequencies."""

import numpy as np
import pytest

from armside.ilc import AllPass, ZeroPhaseButterworth
from armside.ilc.analysis import (
    heuristic_criterion,
    largest_common_cutoff,
    largest_cutoff,
    largest_gain_factor,
    largest_gamma,
)
from armside.ilc.analysis.criterion import Contracting, heuristic_gain
from armside.ilc.laws.model_based import Gradient
from armside.ilc.models.peak import AllPassPhase, peak
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix, largest_gain

T_S = 0.004
CASES = range(12)


def resonant(seed):
    """A lag with a resonance of damping 1e-5 to 0.03; and a grid that resolves it."""
    rng = np.random.default_rng(seed)
    damping, at = 10.0 ** rng.uniform(-5, -1.5), rng.uniform(0.1, 2.5)
    pole = np.exp(at * (1j - damping))
    lag = rng.uniform(0.2, 0.9)
    a = np.poly([pole, pole.conjugate(), lag]).real
    b = np.concatenate((np.zeros(rng.integers(1, 4)), rng.standard_normal(3)))
    T = System(b, a, T_S)
    T = T * (1.0 / abs(T.static_gain))
    near = at + (1.0 - abs(pole)) * np.tan(np.linspace(-1.57, 1.57, 20001))
    omega = np.concatenate((np.linspace(0.0, np.pi, 20001), near[(near > 0.0) & (near < np.pi)]))
    return T * np.sign(T.static_gain), np.unique(omega)


@pytest.mark.parametrize("seed", CASES)
def test_the_contraction_is_that_of_a_grid_that_resolves_the_resonance(seed):
    T_u, omega = resonant(seed)
    for Q in (
        ZeroPhaseButterworth(15.0, T_S),
        ZeroPhaseButterworth(100.0, T_S, order=1),
        AllPass(),
    ):
        fine = heuristic_criterion(T_u, 0.8, 3, Q, omega)
        ours = heuristic_criterion(T_u, 0.8, 3, Q)
        assert ours.bound is not None
        assert fine.contraction <= ours.bound
        assert ours.contraction == pytest.approx(ours.bound, rel=1e-6)
        assert ours.contraction == pytest.approx(fine.contraction, rel=1e-5)


@pytest.mark.parametrize("seed", CASES)
def test_the_largest_gain_and_cutoff_are_the_edge_of_the_criterion(seed):
    T_u, _ = resonant(seed)
    gamma = largest_gamma(T_u, [3], [15.0])[0, 0]
    Q = ZeroPhaseButterworth(15.0, T_S)
    # below the edge the contraction reaches 1 at rest alone, where Q is 1 and nothing is learned
    assert heuristic_criterion(T_u, 0.999 * gamma, 3, Q).contraction < 1.0 + 1e-9
    assert not heuristic_criterion(T_u, 1.001 * gamma, 3, Q).is_met
    edge = largest_cutoff(T_u, 0.5, 3)
    if 0.0 < edge < 100.0:
        assert heuristic_criterion(T_u, 0.5, 3, ZeroPhaseButterworth(0.999 * edge, T_S)).is_met
        wider = ZeroPhaseButterworth(1.001 * edge, T_S)
        assert not heuristic_criterion(T_u, 0.5, 3, wider).is_met


@pytest.mark.parametrize("seed", CASES)
def test_no_frequency_of_the_error_grows_with_the_default_step_of_a_gradient(seed):
    T_u, omega = resonant(seed)
    highest = np.square(np.abs(T_u.response(omega))).max()
    assert Gradient(T_u=T_u).step * highest <= 1.0
    assert largest_gain(T_u) ** 2 == pytest.approx(highest, rel=1e-5)


def test_the_phase_of_an_all_pass_grows_by_its_degree():
    poles = np.array([0.0, 0.5, -0.3, 0.999 * np.exp(0.7j), 0.999 * np.exp(-0.7j)])
    phase = AllPassPhase(poles)
    assert phase(np.array([np.pi])) - phase(np.array([0.0])) == pytest.approx(5 * np.pi)
    omega = phase.grid(0.1)
    assert np.diff(phase(omega)).max() < 0.2
    by_difference = (phase(omega + 1e-7) - phase(omega - 1e-7)) / 2e-7
    z = np.exp(1j * omega)[:, None]
    exact = ((1 - np.abs(poles) ** 2) / np.abs(z - poles) ** 2).sum(axis=1)
    np.testing.assert_allclose(by_difference, exact, rtol=1e-5)


def test_a_response_without_a_peak_is_bounded_in_few_points():
    found = peak(np.ones_like, np.zeros(5, dtype=complex))
    assert found.bound == pytest.approx(1.0, abs=1e-6)
    assert len(found.omega) < 1e5


COUPLED = SystemMatrix(
    (
        (System([0, 0.5], [1, -0.5], T_S), resonant(3)[0] * 0.02),
        (System([0, 0, 0.1], [1, -0.8], T_S), System([0, 0.3], [1, -0.7], T_S)),
    )
)


def test_coupled_motors_contract_by_the_largest_singular_value():
    Q, gamma, delta = ZeroPhaseButterworth((10.0, 20.0), T_S), np.array([0.7, 0.5]), (2, 1)
    ours = heuristic_criterion(COUPLED, gamma, delta, Q)
    omega = np.unique(np.concatenate((resonant(3)[1][::10], np.linspace(0, np.pi, 3000))))
    L = heuristic_gain(COUPLED, gamma, delta).response(omega)
    iteration = Q.response(omega)[:, :, None] * (np.eye(2) - L @ COUPLED.response(omega))
    fine = np.linalg.svd(iteration, compute_uv=False).max()
    assert ours.bound is not None
    assert fine <= ours.bound
    assert ours.bound == pytest.approx(fine, rel=1e-4)
    with pytest.raises(ValueError, match="needs one Q for all motors"):
        heuristic_criterion(COUPLED, gamma, delta, Q, of=Contracting.ERROR)


def test_uncoupled_motors_have_the_limits_of_the_worst_one():
    one, two = System([0, 0, 0.3], [1, -0.7], T_S), System([0, 0, 0, 0.4], [1, -0.6], T_S)
    T_u, Q = SystemMatrix.diagonal([one, two]), ZeroPhaseButterworth(20.0, T_S)
    each = [largest_gamma(T, [3], [20.0])[0, 0] for T in (one, two)]
    assert largest_gain_factor(T_u, 1.0, 3, Q) == pytest.approx(min(each), rel=1e-4)
    each = [largest_cutoff(T, 0.9, 1) for T in (one, two)]
    assert largest_common_cutoff(T_u, 0.9, 1) == pytest.approx(min(each), rel=1e-4)
