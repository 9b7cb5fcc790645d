"""Laws that look back or change over the iterations, of noise, points and laps."""

from itertools import cycle

import numpy as np
import pytest

from armside.ilc import ZeroPhaseButterworth, learn
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.memory import (
    Adaptive,
    DisturbanceObserver,
    FrequencyKalman,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.model_based import ModelInverse
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.robust import h_infinity
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import TwoMassJoint, TwoMassLoop, TwoMassPlant

from .signals import ARX, T_MOTOR, T_S, bump, error_norms, low_pass

# More than one iteration back


def test_an_internal_model_rejects_a_pattern_that_plain_learning_repeats():
    reference = 0 * bump(400)
    loads = [bump(400), 2 * bump(400)]  # alternating, as an even and an odd payload

    def run(law):
        plant = LinearPlant(T_u=ARX, reference=reference, loads=loads)
        return error_norms(plant, law, reference, 30)

    L = ModelInverse(T_u=ARX, learned=ZeroPhaseButterworth(40.0, T_S))
    plain = run(FirstOrder(L=L))
    known = run(internal_model(periodic_pattern(2), L=L))
    assert plain[-1] > 0.4 * plain[0]  # it corrects each time what was wrong the time before
    assert known[-1] < 1e-3 * known[0]


def test_even_and_odd_payloads_of_the_joint_are_learned_apart():
    """Thesis 7.6: a mass m in even cycles and 2 m in odd ones, after Chen and Moore (2002)."""
    light = TwoMassPlant()
    heavy = TwoMassPlant(
        loop=TwoMassLoop(joint=TwoMassJoint(Ja=2 * 0.0991), reference_model=TwoMassJoint())
    )
    np.testing.assert_array_equal(light.motor_reference, heavy.motor_reference)
    Q = ZeroPhaseButterworth(6.0, 0.01)
    L = ModelInverse(T_u=T_MOTOR, learned=Q, regularisation=1e-4)

    class Alternating:
        def __init__(self):
            self.plants = cycle([light, heavy])

        def run(self, correction, /):
            return next(self.plants).run(correction)

    def run(law):
        return error_norms(
            Alternating(),
            law,
            light.motor_reference,
            40,
            output_of=lambda record: record.motor,
        )

    plain = run(FirstOrder(Q=Q, L=L))
    known = run(internal_model(periodic_pattern(2), L=L, Q=Q))
    assert max(known[-2:]) < 0.5 * max(plain[-2:])
    assert max(known[-2:]) < 0.2 * known[0]


def test_a_disturbance_observer_finds_a_pattern_it_was_not_told():
    reference = 0 * bump(400)
    shapes = [bump(400), np.roll(bump(400), 30), -bump(400)]
    plant = LinearPlant(T_u=ARX, reference=reference, loads=shapes)
    L = ModelInverse(T_u=ARX, learned=ZeroPhaseButterworth(40.0, T_S))
    law = DisturbanceObserver(T_u=ARX, L=L, order=3, ridge=1e-10)
    norms = error_norms(plant, law, reference, 15)
    assert max(norms[7:]) < 0.01 * norms[0]


# Laws that change


def test_an_adaptive_gain_averages_noise_that_a_constant_gain_learns():
    reference = bump(400)
    noise = 0.05

    def run(law, seed):
        rng = np.random.default_rng(seed)
        plant = LinearPlant(T_u=ARX, reference=reference, noise=noise, rng=rng)
        *_, last = learn(plant, law, reference, 20)
        return np.linalg.norm(reference - ARX.simulate(reference + last.correction))

    L = ModelInverse(T_u=ARX, learned=ZeroPhaseButterworth(60.0, T_S))
    constant = FirstOrder(L=L)
    adaptive = Adaptive(L=L, noise_variance=noise**2, initial_variance=0.1)
    true_errors = [(run(adaptive, seed), run(constant, seed)) for seed in range(3)]
    assert all(ours < 0.6 * theirs for ours, theirs in true_errors)


def test_an_adaptive_gain_averages_noise_as_a_mean_does():
    """On a plant of 1 the correction after k iterations is the mean of k noisy readings."""
    law = Adaptive(L=PType(gamma=1.0), noise_variance=1e-4, initial_variance=1e2)
    rng, memory, u = np.random.default_rng(0), None, np.zeros((2000, 1))
    for k in range(1, 31):
        u, memory = law.step(u, rng.normal(0.0, 1e-2, u.shape) - u, memory)
        if k in (10, 30):
            # 2000 samples: 3 % of scatter; false alarms keep another per cent
            assert np.var(u) == pytest.approx(1e-4 / k, rel=0.15)


def test_the_direct_term_of_7_4_is_learned_along():
    """u_{k+1} = Q (u_k + L e_k) + C e_{k+1} is FirstOrder with L + C, on a plant with C."""
    C = System([0.4, -0.2], [1, -0.5], T_S)
    reference, Q, L = bump(), low_pass(), PType(gamma=0.5, delta=5)
    # solved iteration by iteration: e = r - T_u (r + u) with u = w + C e
    loop = (ARX * C).feedback()
    u, e, norms = np.zeros_like(reference), None, []
    for _ in range(4):
        w = np.zeros_like(reference) if e is None else Q(u + L(e))
        free = reference - ARX.simulate(reference + w)
        e = free - loop.simulate(free)
        u = w + C.simulate(e)
        norms.append(two_norm(e)[0])

    class Together:
        """L + C."""

        def check(self, n_samples, n_columns):
            pass

        def __call__(self, signal):
            return L(signal) + C.simulate(signal)

    plant = LinearPlant(T_u=ARX, reference=reference, C=C)
    same = error_norms(plant, FirstOrder(Q=Q, L=Together()), reference, 3)
    np.testing.assert_allclose(same, norms, rtol=1e-9)
    other = error_norms(plant, FirstOrder(Q=Q, L=L), reference, 3)
    assert abs(other[2] / norms[2] - 1) > 0.05


DIRECT = System(np.ones(1), np.ones(1), T_S)
Q = ZeroPhaseButterworth(10.0, T_S)


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


def test_a_wrong_model_still_converges_within_the_uncertainty_that_was_stated():
    L = h_infinity(ARX, Q, uncertainty=0.3)
    assert L.reached < 1 / np.sqrt(2)
    reference = bump(300)
    for factor in (0.7, 1.3):
        plant = LinearPlant(T_u=ARX * factor, reference=reference)
        norms = error_norms(plant, FirstOrder(L=L, Q=Q), reference, 10)
        assert norms[-1] < 0.2 * norms[0]
