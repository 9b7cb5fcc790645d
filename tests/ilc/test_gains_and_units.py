"""Gains, margins and units of laws and designs; what a loop runs, and what counts as growth."""

import numpy as np
import pytest
from scipy.stats import chi2

from armside.ilc.analysis.criterion import frequency_grid, heuristic_criterion
from armside.ilc.analysis.limits import largest_gamma
from armside.ilc.analysis.proposal import propose
from armside.ilc.estimation.consistency import Whiteness, bounds, whiteness
from armside.ilc.filters import ALL_PASS, End, ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder
from armside.ilc.learning import learn
from armside.ilc.measures.norms import circle_maxdev, circle_rms
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import FrictionPlant, step_reference
from armside.ilc.two_mass_study import heuristic

STEP = 0.004


def test_a_first_result_stands_for_the_first_run_alone():
    ran = []

    class Plant:
        def run(self, correction, /):
            ran.append(correction.copy())
            return 0.5 * correction

    reference = np.ones((20, 1))
    law = FirstOrder(L=ALL_PASS)
    trials = list(learn(Plant(), law, reference, 3, first_result=np.full((20, 1), 0.25)))
    assert len(ran) == 3
    assert trials[0].output == pytest.approx(np.full((20, 1), 0.25))
    for trial in trials[1:]:
        assert trial.output == pytest.approx(0.5 * trial.correction)
    assert [trial.k for trial in trials] == [0, 1, 2, 3]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_deviation_counts_inwards_and_outwards(sign):
    radii = 5e-3 + sign * np.array([0.0, 1e-4, 3e-4])
    assert circle_maxdev(radii, 5e-3) == pytest.approx(3e-4)
    assert circle_rms(radii, 5e-3) == pytest.approx(np.sqrt(10 / 3) * 1e-4)


# Designs


@pytest.mark.parametrize("bandwidth", [5.0, 10.0, 15.0])
def test_a_proposal_leaves_its_gain_margin_and_states_its_convergence(bandwidth):
    """gamma = 1 / |T_u(0)|, but at most 0.6 of the largest that converges."""
    slow = System(np.array([0, 0, 0, 0, 0, 0.3]), np.array([1.0, -0.7]), STEP)
    found = propose(slow, bandwidth)
    limit = largest_gamma(slow, [found.delta], [bandwidth])[0, 0]
    assert found.largest_gamma == pytest.approx(limit)
    assert found.gamma == pytest.approx(min(1.0 / slow.static_gain, 0.6 * limit))
    Q = ZeroPhaseButterworth(bandwidth, STEP)
    assert heuristic_criterion(slow, 0.99 * limit, found.delta, Q).is_met
    assert not heuristic_criterion(slow, 1.01 * limit, found.delta, Q).is_met
    n = found.iterations_to_5_percent
    assert found.contraction**n <= 0.05
    assert n == 1 or found.contraction ** (n - 1) > 0.05
    # what is left at a frequency: (1 - Q) / (1 - Q (1 - L T))
    omega = 2 * np.pi * 8.0 * STEP
    q, LT = Q.response(np.array([omega]))[0], found.gamma * np.exp(1j * omega * found.delta)
    LT = LT * slow.response(np.array([omega]))[0]
    assert found.residual(8.0) == pytest.approx(abs((1 - q) / (1 - q * (1 - LT))))
    assert frequency_grid().max() == pytest.approx(np.pi)


def test_the_law_of_chapter_8_shifts_zeros_in():
    law = heuristic(17.0)
    assert law.end is End.ZERO
    assert (law.gamma, law.delta, law.Q.cutoff) == (0.9, 5, 17.0)


# Friction


@pytest.fixture(scope="module")
def moves():
    """The joint of chapter 8 with dry friction, moved to either side."""
    reference = step_reference(400)
    plants = [FrictionPlant(arm_reference=s * reference, coulomb=0.05) for s in (1.0, -1.0)]
    return [plant.run(np.zeros_like(reference)) for plant in plants]


def test_friction_acts_alike_in_both_directions(moves):
    there, back = moves
    assert back.motor == pytest.approx(-there.motor, abs=1e-12)
    assert back.arm == pytest.approx(-there.arm, abs=1e-12)


def test_friction_holds_the_motor_back_and_never_drives_it(moves):
    free = FrictionPlant(arm_reference=step_reference(400))
    moved = free.run(np.zeros_like(free.arm_reference)).motor
    sticking = moves[0].motor
    error = [np.abs(free.motor_reference - m).max() for m in (moved, sticking)]
    assert error[1] > error[0]
    still = FrictionPlant(arm_reference=np.zeros((50, 1)), coulomb=0.05)
    assert not still.run(np.zeros((50, 1))).motor.any()


# Consistency of filters


@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.99])
def test_bounds_of_a_consistent_filter_are_chi_squared(confidence):
    low, high = bounds(40, 6, confidence)
    expected = chi2.interval(confidence, 40 * 6)
    assert (low, high) == pytest.approx(tuple(np.array(expected) / 40))


@pytest.mark.parametrize(("factor", "white"), [(1.0, True), (1.45, True), (1.55, False)])
def test_innovations_of_twice_their_size_are_not_those_of_the_model(factor, white):
    e = np.random.default_rng(3).standard_normal((3000, 2))
    e = factor * e / np.sqrt(np.mean(e**2, axis=0))
    found = whiteness(e)
    assert isinstance(found, Whiteness)
    assert found.rms == pytest.approx([factor, factor])
    assert found.is_white is white
