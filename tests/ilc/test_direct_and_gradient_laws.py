"""Direct term, gain matrices, and gradients with and without a model."""

import numpy as np
import pytest
from scipy.linalg import toeplitz

from armside.ilc import Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.laws.first_order import FirstOrder, MatrixGain
from armside.ilc.laws.model_based import Gradient
from armside.ilc.laws.model_free import FiniteDifference, MeasuredGradient, b_splines
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.linear_plant import LinearPlant, with_direct_term
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix, largest_gain
from armside.ilc.models.two_mass import TwoMassLoop

from .signals import bump, error_norms

T_S = 0.004
T_MOTOR = TwoMassLoop().T_motor
ARX = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], T_S)


# Direct term, D-type, several motors


def test_a_direct_term_is_feedback_beside_the_learning():
    C = System([0.4, -0.2], [1, -0.5], T_S)
    reference = bump()
    plant = LinearPlant(T_u=ARX, reference=reference, C=C)
    plain = LinearPlant(T_u=ARX, reference=reference)
    u = 0.3 * bump()[::-1]
    y = plant.run(u)
    # the definition: the plant that is given u + C e in the same iteration returns the same y
    np.testing.assert_allclose(plain.run(u + C.simulate(reference - y)), y, atol=1e-12)
    # and what the law sees is T_u / (1 + T_u C)
    effect = plant.run(u) - plant.run(0 * u)
    np.testing.assert_allclose(with_direct_term(ARX, C).simulate(u), effect, atol=1e-12)


def test_a_direct_term_that_destabilises_is_refused_by_name():
    with pytest.raises(ValueError, match="the loop of T_u and the direct term C is unstable"):
        LinearPlant(T_u=ARX, reference=bump(), C=System([9.0], [1.0], T_S))


def test_a_gain_matrix_learns_motors_that_a_diagonal_gain_cannot():
    # strong coupling with the wrong sign: each motor answers mostly to the other's correction
    mixing = np.array([[0.2, 1.0], [1.0, 0.2]])
    T_u = SystemMatrix(tuple(tuple(ARX * float(m) for m in row) for row in mixing))
    reference = bump(300, 2)
    Q = ZeroPhaseButterworth(10.0, T_S)
    joint = FirstOrder(Q=Q, L=MatrixGain(gamma=0.9 * np.linalg.inv(mixing), delta=6))
    each = Heuristic(Q=Q, gamma=0.9, delta=6)
    plant = LinearPlant(T_u=T_u, reference=reference)
    *_, last = learn(plant, joint, reference, 20)
    assert not last.diverged
    assert (two_norm(last.error) < 0.05 * two_norm(reference)).all()
    *_, last = learn(plant, each, reference, 20)
    assert last.diverged


# Gradients with and without a model


@pytest.mark.parametrize("T_u", [T_MOTOR, SystemMatrix(((ARX, ARX * 0.5), (ARX * 0.2, ARX)))])
def test_the_adjoint_is_the_transpose(T_u):
    columns = 1 if isinstance(T_u, System) else 2
    u, e = np.random.default_rng(0).standard_normal((2, 80, columns))
    assert (T_u.simulate(u) * e).sum() == pytest.approx((u * T_u.adjoint(e)).sum(), rel=1e-10)


def test_the_gradient_step_is_limited_by_the_largest_gain():
    # the norm of the lifted system approaches it from below as records grow
    T = toeplitz(T_MOTOR.impulse(800), np.zeros(800))
    assert 0.99 < np.linalg.norm(T, 2) / largest_gain(T_MOTOR) < 1.0
    with pytest.raises(ValueError, match=r"below 2/max\|T_u\|\^2"):
        Gradient(T_u=ARX, step=2.1 / largest_gain(ARX) ** 2)


@pytest.mark.parametrize("coupled", [False, True])
def test_the_gradient_measured_by_time_reversal_is_that_of_the_model(coupled):
    T_u = SystemMatrix(((ARX, ARX * 0.5), (ARX * -0.2, ARX))) if coupled else ARX
    reference = bump(200, 2)
    plant = LinearPlant(T_u=T_u, reference=reference)
    law = MeasuredGradient(experiment=plant.run, coupled=coupled)
    u = np.zeros_like(reference)
    e = reference - plant.run(u)
    change = law(u, e)
    g = T_u.adjoint(e)
    response = T_u.simulate(g)
    best_step = (response * e).sum() / (response**2).sum()
    np.testing.assert_allclose(change, best_step * g, atol=1e-9)


def test_the_measured_gradient_learns_without_a_model():
    reference = bump(200)
    plant = LinearPlant(T_u=ARX, reference=reference)
    norms = error_norms(plant, MeasuredGradient(experiment=plant.run), reference, 10)
    assert (np.diff(norms) < 0.0).all()
    assert norms[10] < 0.05 * norms[0]


def test_finite_differences_learn_a_plant_that_is_not_linear():
    reference = bump(200)

    class Saturating:
        def run(self, correction, /):
            return np.tanh(ARX.simulate(0.5 * reference + correction))

    plant = Saturating()
    goal = 0.5 * reference
    law = FiniteDifference(experiment=plant.run, basis=b_splines(200, 50))
    norms = error_norms(plant, law, goal, 5)
    assert norms[5] < 0.02 * norms[0]
