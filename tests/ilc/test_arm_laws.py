"""Laws of whole arms, laws on a simulated plant, and laws that transfer to other references."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from armside.ilc import AllPass, Heuristic, learn
from armside.ilc.identification.friction import stops
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.transfer import (
    LARGEST_ORDER,
    BasisFunctions,
    RationalBasis,
    across,
    correction_of,
    derivatives,
    fitted,
    led,
)
from armside.ilc.laws.wrappers import Simulated
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import Complex, System
from armside.ilc.models.system_matrix import SystemMatrix

from .signals import T_S

ZERO = System(np.array([0, 1.0, -0.7]), np.array([1, -1.5, 0.56]), T_S)
SERVO = ZERO * (1.0 / ZERO.static_gain)
"""Two poles and a zero: its inverse is rational."""


def there_and_back(n_samples: int, seconds: float, size: float):
    """A smooth reference that begins and ends at rest at 0."""

    def rise(x):
        x = np.clip(x, 0.0, 1.0)
        return x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)

    t = np.arange(n_samples) * T_S - 0.2
    return size * (rise(t / seconds) - rise((t - seconds - 0.1) / seconds))[:, None]


LEARNED, OTHER = there_and_back(400, 0.4, 1.0), there_and_back(450, 0.3, -2.0)


def left(correction, reference, T_u=SERVO):
    plant = LinearPlant(T_u=T_u, reference=reference)
    size = np.linalg.norm(reference - plant.run(0 * reference))
    return np.linalg.norm(reference - plant.run(correction)) / size


@pytest.mark.parametrize("order", [1, LARGEST_ORDER])
def test_derivatives_of_a_parabola_are_its_slope_and_curvature_and_no_more(order):
    t = 0.01 * np.arange(60)
    found = derivatives((t**2)[:, None], 0.01, order)
    assert found.shape == (60, 1, order)
    expected = np.stack([2.0 * t, np.full(60, 2.0), *np.zeros((LARGEST_ORDER, 60))], axis=1)
    inside = slice(LARGEST_ORDER, -LARGEST_ORDER)  # differences at the ends are one-sided
    scale = 100.0 ** np.arange(1, order + 1)  # rounding of each difference over the sample time
    error = np.abs(found[inside, 0] - expected[inside, :order]) / scale
    assert error.max() < 1e-12


def test_parameters_of_one_reference_leave_nothing_of_another():
    law = BasisFunctions(T_u=SERVO, basis=derivatives(LEARNED, T_S, 4))
    *_, last = learn(LinearPlant(T_u=SERVO, reference=LEARNED), law, LEARNED, 1)
    theta = law.parameters(last.correction)
    assert left(correction_of(derivatives(OTHER, T_S, 4), theta), OTHER) < 1e-4


def test_rational_functions_are_the_exact_inverse_of_a_plant_with_a_zero():
    law = RationalBasis(T_u=SERVO, reference=LEARNED, n_numerator=2, n_denominator=1)
    first, last = learn(LinearPlant(T_u=SERVO, reference=LEARNED), law, LEARNED, 1)
    assert np.linalg.norm(last.error) < 1e-10 * np.linalg.norm(first.error)
    found = law.parameters(last.correction, last.error)
    assert left(found.correction(OTHER), OTHER) < 1e-10
    omega = np.linspace(0.1, 3.0, 20)  # u = A/B r makes y = r: A/B = 1/T_u - 1
    np.testing.assert_allclose(found.response(omega), 1 / SERVO.response(omega) - 1, atol=1e-8)


def test_coupled_motors_learn_what_the_others_references_do():
    T_u = SystemMatrix(((SERVO, SERVO * 0.3), (SERVO * -0.2, SERVO)))
    both = np.hstack((LEARNED, there_and_back(400, 0.35, 0.5)))
    plain, crossed = derivatives(both, T_S, 3), across(derivatives(both, T_S, 3))
    moved = np.concatenate((both[:, :, None], plain), axis=2)
    sizes = []
    for basis in (plain, crossed, across(moved)):
        law = BasisFunctions(T_u=T_u, basis=basis)
        *_, last = learn(LinearPlant(T_u=T_u, reference=both), law, both, 2)
        sizes.append(np.linalg.norm(last.error))
    assert sizes[2] < 0.01 * sizes[0]
    assert sizes[0] > sizes[1] > sizes[2]


def test_a_stop_is_elastic_then_slips_and_turns_with_the_reference():
    up_and_down = np.concatenate((np.linspace(0, 3, 31), np.linspace(3, 0, 31)[1:]))[:, None]
    (found,) = stops(up_and_down, [1.0])[:, 0].T
    assert found[5] == pytest.approx(0.5)
    assert found[10:31] == pytest.approx(1.0)
    assert found[40] == pytest.approx(0.0, abs=1e-9)
    assert found[-1] == pytest.approx(-1.0)


def test_fitted_parameters_serve_several_references_at_once():
    theta = np.array([[0.3, -0.02]])
    bases = [derivatives(r, T_S, 2) for r in (LEARNED, OTHER)]
    corrections = [correction_of(basis, theta) for basis in bases]
    np.testing.assert_allclose(fitted(bases, corrections, 1e-12), theta, rtol=1e-6)


def test_a_lead_is_the_function_earlier():
    basis = derivatives(LEARNED, T_S, 1)
    np.testing.assert_array_equal(led(basis, (0, 3))[:-3, :, 1], basis[3:, :, 0])


class Gain:
    """A plant of one input and one output that is a gain."""

    def __init__(self, gain: float) -> None:
        self.gain = gain

    def response(self, omega: ArrayLike) -> Complex:
        return np.full((len(np.atleast_1d(omega)), 1, 1), self.gain, dtype=np.complex128)


def inverse_at(gain: float) -> RegularisedInverse:
    shared = {"sample_time": 0.004, "cutoff": 10.0, "output_weight": (1.0,), "input_size": (1.0,)}
    return RegularisedInverse(G=Gain(gain), gamma=1.0, regularisation=1e-6, **shared)


SAMPLES = 500


LENGTH, STEP = 400, 0.004
MIX = np.array([[1.0, 0.3, 0.2], [-0.2, 0.8, 0.5]])


class Lag:
    """Two outputs of three inputs through a lag of 12 Hz and 12 ms of delay."""

    def __init__(self, mix=MIX):
        self.mix = mix

    def response(self, omega):
        s = 1j * np.asarray(omega) / STEP
        one = np.exp(-0.012 * s) / (1.0 + s / (2 * np.pi * 12.0))
        return one[:, None, None] * self.mix

    def run(self, u):
        U = np.fft.rfft(u, 2 * LENGTH, axis=0)
        Y = (self.response(2 * np.pi * np.fft.rfftfreq(2 * LENGTH)) @ U[:, :, None])[:, :, 0]
        return np.fft.irfft(Y, 2 * LENGTH, axis=0)[:LENGTH]


def reference():
    t = np.arange(LENGTH) / LENGTH
    bump = np.sin(np.pi * np.clip((t - 0.15) / 0.7, 0, 1)) ** 2
    return np.stack([bump * np.sin(6 * np.pi * t), bump * np.cos(4 * np.pi * t)], axis=1)


def inverse(**options):
    return RegularisedInverse(
        **{
            "G": Lag(),
            "sample_time": STEP,
            "cutoff": 20.0,
            "output_weight": (1.0, 1.0),
            "input_size": (1.0, 1.0, 1.0),
            "regularisation": 1e-4,
        }
        | options
    )


def repeated(law, plant, iterations):
    u, sizes = np.zeros((LENGTH, 3)), []
    for _ in range(iterations + 1):
        e = reference() - plant.run(u)
        sizes.append(np.sqrt(np.square(e).mean()))
        u = law(u, e)
    return u, np.array(sizes)


def test_redundant_inputs_take_the_smallest_correction():
    u, _ = repeated(inverse(), Lag(), 5)
    kernel = np.linalg.svd(MIX)[2][-1]
    assert np.abs(u @ kernel).max() < 1e-3 * np.abs(u).max()


def test_a_plant_within_a_third_of_the_model_contracts_and_a_reversed_one_does_not():
    law = inverse()
    omega = np.linspace(0.0, 2 * np.pi * 15.0 * STEP, 50)
    gain = law.contraction(omega, Lag(1.3 * MIX))
    # In the kernel nothing moves, so the norm is Q there: look at what the outputs do.
    assert gain.max() <= 1.0 + 1e-9
    _, sizes = repeated(law, Lag(1.3 * MIX), 5)
    assert (np.diff(sizes) < 0.0).all()
    assert law.contraction(omega, Lag(-MIX)).max() > 1.5


SIMULATED = Simulated(
    simulation=np.copy, law=Heuristic(Q=AllPass(), gamma=1.0), weight=(1.0,), passes=1
)
WHOLE = ScheduledInverse(laws=(inverse_at(1.0),), weights=np.ones((SAMPLES, 1)))


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: derivatives(LEARNED, T_S, 0), "order must be 1 to 10, got 0"),
        (lambda: stops(LEARNED, [0.0]), "widths must be > 0"),
        (lambda: fitted([], [], 1.0), "no pairs"),
        (lambda: fitted([np.ones((4, 1, 1))], [np.ones((4, 1))], 0.0), "ridge must be > 0"),
        (lambda: BasisFunctions(T_u=SERVO, basis=np.ones((5, 2))), r"shape \(N, n, p\)"),
        (lambda: RationalBasis(T_u=SERVO, reference=LEARNED, n_numerator=0), "at least 1 numer"),
        (lambda: replace(WHOLE, weights=0.5 * WHOLE.weights), "sum 1"),
        (lambda: WHOLE.check(400, 1), "cover 500 samples"),
        (lambda: replace(SIMULATED, passes=0), "passes must be >= 1, got 0"),
        (lambda: replace(SIMULATED, weight=(1.0, 1.0)).check(90, 1), "weight must have 1 "),
        (lambda: inverse(cutoff=125.0), "cutoff"),
        (lambda: inverse(gamma=2.0), "gamma"),
        (lambda: inverse(regularisation=0.0), "regularisation"),
        (lambda: inverse(output_weight=(0.0, 0.0)), "output_weight"),
        (lambda: inverse(input_size=(1.0, 0.0, 1.0)), "input_size"),
        (lambda: inverse(limit=0.0), "limit"),
    ],
)
def test_what_cannot_be_is_refused_by_name(build, said):
    with pytest.raises(ValueError, match=said):
        build()
