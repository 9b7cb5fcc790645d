"""Laws that look back or change over the iterations, of noise, points and laps."""

from itertools import cycle

import numpy as np

from armside.ilc import ZeroPhaseButterworth, learn
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.memory import (
    Adaptive,
    DisturbanceObserver,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.model_based import ModelInverse
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


Q = ZeroPhaseButterworth(10.0, T_S)


def test_a_wrong_model_still_converges_within_the_uncertainty_that_was_stated():
    L = h_infinity(ARX, Q, uncertainty=0.3)
    assert L.reached < 1 / np.sqrt(2)
    reference = bump(300)
    for factor in (0.7, 1.3):
        plant = LinearPlant(T_u=ARX * factor, reference=reference)
        norms = error_norms(plant, FirstOrder(L=L, Q=Q), reference, 10)
        assert norms[-1] < 0.2 * norms[0]
