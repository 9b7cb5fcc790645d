"""Basis functions, polynomial and rational: parameters of one reference serve others."""

import numpy as np
import pytest

from armside.ilc import learn
from armside.ilc.identification.friction import stops
from armside.ilc.laws.transfer import (
    BasisFunctions,
    RationalBasis,
    across,
    correction_of,
    derivatives,
    fitted,
    led,
)
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

T_S = 0.004
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


def test_the_polynomial_law_is_the_least_squares_step_and_stays_there():
    basis = derivatives(LEARNED, T_S, 3)
    law = BasisFunctions(T_u=SERVO, basis=basis, ridge=1e-14)
    plant = LinearPlant(T_u=SERVO, reference=LEARNED)
    first, second, third = learn(plant, law, LEARNED, 2)
    response = np.stack([SERVO.simulate(basis[:, :, i])[:, 0] for i in range(3)], axis=1)
    theta = np.linalg.lstsq(response, first.error[:, 0])[0]
    np.testing.assert_allclose(second.correction[:, 0], basis[:, 0] @ theta, atol=1e-7)
    np.testing.assert_allclose(third.error, second.error, atol=1e-7)


def test_parameters_of_one_reference_leave_nothing_of_another():
    law = BasisFunctions(T_u=SERVO, basis=derivatives(LEARNED, T_S, 4))
    *_, last = learn(LinearPlant(T_u=SERVO, reference=LEARNED), law, LEARNED, 1)
    theta = law.parameters(last.correction)
    assert left(correction_of(derivatives(OTHER, T_S, 4), theta), OTHER) < 1e-4


def test_a_learned_correction_itself_does_not_transfer():
    law = BasisFunctions(T_u=SERVO, basis=derivatives(LEARNED, T_S, 4))
    *_, last = learn(LinearPlant(T_u=SERVO, reference=LEARNED), law, LEARNED, 1)
    assert left(np.resize(last.correction, OTHER.shape), OTHER) > 1.0


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


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: derivatives(LEARNED, T_S, 0), "order must be >= 1"),
        (lambda: stops(LEARNED, [0.0]), "widths must be > 0"),
        (lambda: fitted([], [], 1.0), "no pairs"),
        (lambda: fitted([np.ones((4, 1, 1))], [np.ones((4, 1))], 0.0), "ridge must be > 0"),
        (lambda: BasisFunctions(T_u=SERVO, basis=np.ones((5, 2))), r"shape \(N, n, p\)"),
        (
            lambda: RationalBasis(T_u=SERVO, reference=LEARNED, n_numerator=0),
            "at least 1 numerator",
        ),
    ],
)
def test_what_is_no_basis_is_refused(build, message):
    with pytest.raises(ValueError, match=message):
        build()
