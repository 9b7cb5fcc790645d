"""Point-to-point, Kalman filter of each frequency, repetitive control, and minimax matching."""

import numpy as np
import pytest
from scipy.linalg import toeplitz

from armside.ilc import ZeroPhaseButterworth, learn
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.memory import FrequencyKalman
from armside.ilc.laws.model_based import ModelInverse
from armside.ilc.laws.norm_optimal import PointToPoint
from armside.ilc.laws.repetitive import PlugIn, Repetitive, around
from armside.ilc.laws.robust import h_infinity
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import TwoMassLoop

from .signals import bump, error_norms

T_S = 0.004
ARX = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1, -0.4884]), T_S)
DIRECT = System(np.ones(1), np.ones(1), T_S)
Q = ZeroPhaseButterworth(10.0, T_S)


def test_points_are_reached_with_the_smallest_correction_that_reaches_them():
    reference, points = bump(90), [40, 55, 80]
    law = PointToPoint(T_u=ARX, points=points, n_samples=90, correction=1e-7, change=1e-5)
    plant = LinearPlant(T_u=ARX, reference=reference)
    *_, last = learn(plant, law, reference, 3)
    rows = toeplitz(ARX.impulse(90), np.zeros(90))[points]
    e_0 = reference - plant.run(0 * reference)
    smallest = np.linalg.pinv(rows) @ e_0[points]
    np.testing.assert_allclose(last.correction, smallest, atol=1e-5 * np.abs(smallest).max())
    assert np.abs(last.error[points]).max() < 1e-5


def test_a_point_beyond_the_record_is_refused():
    with pytest.raises(ValueError, match="points must be samples 0 to 89"):
        PointToPoint(T_u=ARX, points=[90], n_samples=90)


def test_what_repeats_is_averaged_over_all_runs():
    """Direct plant: u_k - d is the mean of k noises, so its power is that of one over k."""
    rng, n = np.random.default_rng(0), 400
    d = 20.0 * rng.standard_normal((n, 1))
    law, ends = FrequencyKalman(L=PType(gamma=1.0), noise=1.0), []
    for _ in range(40):
        plant = LinearPlant(T_u=DIRECT, T_r=DIRECT * 0.0, reference=d, noise=1.0, rng=rng)
        ends.append([t.correction for t in learn(plant, law, d, 8, divergence_ratio=np.inf)])
    inner = slice(20, -20)  # the tapered record is not white at its ends
    power = np.square(np.array(ends) - d)[:, 1:, inner].mean(axis=(0, 2, 3))
    np.testing.assert_allclose(power, 1.0 / np.arange(1, 9), rtol=0.1)


def test_the_noise_optimal_gain_ends_below_a_constant_gain():
    reference = bump(300)
    L = ModelInverse(T_u=ARX, learned=Q)

    def last(law):
        plant = LinearPlant(T_u=ARX, reference=reference, noise=0.05, rng=np.random.default_rng(1))
        *_, trial = learn(plant, law, reference, 20)
        return np.linalg.norm(
            reference - LinearPlant(T_u=ARX, reference=reference).run(trial.correction)
        )

    optimal = last(FrequencyKalman(L=L, noise=0.05))
    constant = last(FirstOrder(L=L))
    assert optimal < 0.6 * constant


def test_change_between_iterations_keeps_the_gain_up():
    law = FrequencyKalman(L=PType(gamma=1.0), noise=1.0, change=1.0)
    u = e = np.random.default_rng(0).standard_normal((50, 1))
    _, memory = law.step(u, e)
    for _ in range(30):
        _, memory = law.step(u, e, memory)
    P = memory / (2 * 50)  # of P = P / (P + 1) + 1: the golden ratio
    np.testing.assert_allclose(P, 0.5 * (1.0 + np.sqrt(5.0)), rtol=1e-6)


def laps(n_laps: int, period: int = 100):
    t = np.arange(n_laps * period) / period
    return (np.sin(2 * np.pi * t) + 0.3 * np.cos(6 * np.pi * t))[:, None]


def test_a_periodic_correction_learns_laps_and_stays_periodic():
    reference = laps(5)
    law = Repetitive(L=ModelInverse(T_u=ARX, learned=Q), period=100)
    plant = LinearPlant(T_u=ARX, reference=reference)
    first, *_, last = learn(plant, law, reference, 5)
    settled = slice(100, None)
    assert np.linalg.norm(last.error[settled]) < 0.02 * np.linalg.norm(first.error[settled])
    np.testing.assert_allclose(last.correction[100:400], last.correction[200:500], atol=1e-12)


def test_a_plug_in_controller_contracts_lap_by_lap_as_its_criterion_says():
    reference = laps(12)
    L = ModelInverse(T_u=ARX, learned=Q, rate=0.5)
    first = reference - ARX.simulate(reference)
    e = PlugIn(T_u=ARX, L=L, period=100).run(first)
    norms = np.linalg.norm(e.reshape(12, 100), axis=1)
    omega = 2 * np.pi * np.array([1, 3]) / 100  # the harmonics of the reference
    slow, fast = np.sort(np.abs(1 - L.response(omega) * ARX.response(omega)))[::-1]
    assert norms[7] <= 1.1 * slow**5 * norms[2]
    assert norms[7] >= 0.9 * fast**5 * norms[2]
    assert norms[-1] < 0.05 * norms[1]


def test_a_lap_filtered_around_itself_has_no_ends():
    lap = laps(1)
    np.testing.assert_allclose(
        around(Q, np.roll(lap, 30, axis=0)), np.roll(around(Q, lap), 30, axis=0), atol=1e-6
    )


def test_a_record_without_two_laps_is_refused():
    with pytest.raises(ValueError, match="two laps of 100"):
        Repetitive(L=PType(), period=100).check(150, 1)


@pytest.mark.parametrize("uncertainty", [0.0, 0.3])
def test_the_minimax_filter_is_certified_and_better_than_a_shift(uncertainty):
    T_u = TwoMassLoop().T_motor
    band = ZeroPhaseButterworth(10.0, T_u.sample_time)
    L = h_infinity(T_u, band, n_taps=40, uncertainty=uncertainty)
    omega = np.pi * (np.arange(600) + 0.5) / 600

    def value(response):
        LT = response * T_u.response(omega)
        return (band.response(omega) * np.hypot(abs(1 - LT), uncertainty * abs(LT))).max()

    between = 1.02  # a peak between two frequencies of the grid at most over the largest on it
    assert L.reached / between <= value(L.response(omega)) <= L.reached * (1.0 + 1e-9)
    assert L.least <= L.reached <= 1.05 * L.least
    shifts = [value(PType(gamma=0.9, delta=d).response(omega)) for d in range(12)]
    assert L.reached < 0.8 * min(shifts)


def test_a_wrong_model_still_converges_within_the_uncertainty_that_was_stated():
    L = h_infinity(ARX, Q, uncertainty=0.3)
    assert L.reached < 1 / np.sqrt(2)
    reference = bump(300)
    for factor in (0.7, 1.3):
        plant = LinearPlant(T_u=ARX * factor, reference=reference)
        norms = error_norms(plant, FirstOrder(L=L, Q=Q), reference, 10)
        assert norms[-1] < 0.2 * norms[0]


def test_the_filter_in_time_is_its_response():
    L = h_infinity(ARX, Q, n_taps=20, lead=12)
    impulse = np.zeros((101, 1))
    impulse[50] = 1.0
    omega = np.array([0.3, 1.0])
    seen = np.exp(-1j * np.outer(omega, np.arange(101) - 50)) @ L(impulse)[:, 0]
    np.testing.assert_allclose(seen, L.response(omega), rtol=1e-9)


def test_values_out_of_range_are_refused():
    for bad, message in (
        (lambda: h_infinity(ARX, Q, n_taps=5, lead=5), "lead must be in 0"),
        (lambda: h_infinity(ARX, Q, uncertainty=-1.0), "uncertainty must be >= 0"),
        (lambda: FrequencyKalman(L=PType(), noise=0.0), "noise must be > 0"),
        (lambda: Repetitive(L=PType(), period=1), "period and begin"),
    ):
        with pytest.raises(ValueError, match=message):
            bad()
