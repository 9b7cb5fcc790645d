"""Laws and analysis with models that vary, are in states or not square."""

import numpy as np
import pytest

from armside.ilc.analysis import (
    asymptotic_error,
    eigenloci,
    heuristic_criterion,
    largest_cutoff,
    largest_gamma,
)
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder, PType
from armside.ilc.laws.model_based import Gradient, ModelInverse
from armside.ilc.laws.norm_optimal import NormOptimal, PointToPoint
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.robust import h_infinity
from armside.ilc.laws.transfer import BasisFunctions
from armside.ilc.models.conversion import as_state_space
from armside.ilc.models.state_space import StateSpace, TimeVarying
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

N, T_S = 30, 0.01
SLOW = System([0.0, 0.3], [1.0, -0.7], T_S)
LOW = ZeroPhaseButterworth(10.0, T_S)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def lifted(T) -> np.ndarray:
    """Matrix (N p, N m), from products."""
    m = T.n_inputs
    units = np.eye(N * m).reshape(-1, N, m)
    return np.stack([T.simulate(unit).ravel() for unit in units], axis=1)


def models(rng):
    shapes = (N, 3, 3), (N, 3, 2), (N, 1, 3)
    varying = TimeVarying(*(0.4 * rng.standard_normal(shape) for shape in shapes))
    wide = StateSpace(np.diag([0.5, 0.3]), rng.standard_normal((2, 3)), np.eye(2))
    return [varying, wide]


@pytest.mark.parametrize("which", range(2))
def test_a_step_in_basis_functions_on_any_model_is_least_squares(rng, which):
    T = models(rng)[which]
    basis, e = rng.standard_normal((N, T.n_inputs, 2)), rng.standard_normal((N, T.n_outputs))
    Psi = np.zeros((N, T.n_inputs, T.n_inputs, 2))
    for j in range(T.n_inputs):
        Psi[:, j, j] = basis[:, j]
    Psi = Psi.reshape(N * T.n_inputs, -1)
    wanted = Psi @ np.linalg.lstsq(lifted(T) @ Psi, e.ravel(), rcond=None)[0]
    found = BasisFunctions(T_u=T, basis=basis)(np.zeros((N, T.n_inputs)), e)
    np.testing.assert_allclose(found.ravel(), wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("which", range(2))
def test_a_point_to_point_step_on_any_model_is_least_squares(rng, which):
    T = models(rng)[which]
    law = PointToPoint(T_u=T, points=[4, N - 1, 4], n_samples=N, n_columns=T.n_inputs)
    e = rng.standard_normal((N, T.n_outputs))
    G, W = lifted(T), np.zeros((N, T.n_outputs))
    W[[4, N - 1]] = 1.0
    H = G.T @ (W.ravel()[:, None] * G) + (1e-6 + 1e-4) * np.eye(G.shape[1])
    wanted = np.linalg.solve(H, G.T @ (W * e).ravel())
    found = law(np.zeros((N, T.n_inputs)), e)
    np.testing.assert_allclose(found.ravel(), wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())


def test_a_model_in_states_has_the_analysis_of_its_system():
    states = as_state_space(SLOW)
    known, found = (heuristic_criterion(T, 0.6, 2, LOW).bound for T in (SLOW, states))
    assert found == pytest.approx(known, rel=1e-8)
    known, found = (eigenloci(T, 0.6, 2, LOW).spectral_radius for T in (SLOW, states))
    assert found == pytest.approx(known, rel=1e-8)
    assert Gradient(T_u=states).step == pytest.approx(Gradient(T_u=SLOW).step, rel=1e-9)
    e = np.sin(np.arange(N))[:, None]
    known, found = (ModelInverse(T_u=T, learned=LOW)(e) for T in (SLOW, states))
    np.testing.assert_allclose(found, known, rtol=1e-9, atol=1e-12)


def test_a_minimax_filter_takes_a_model_in_any_form():
    known, found = (h_infinity(T, LOW, uncertainty=0.3) for T in (SLOW, as_state_space(SLOW)))
    assert found.reached == pytest.approx(known.reached, rel=1e-6)
    assert found.least == pytest.approx(known.least, rel=1e-6)


def test_the_largest_gain_and_cutoff_take_a_model_in_states(rng):
    known, found = (largest_gamma(T, [0, 2], [5.0, 20.0]) for T in (SLOW, as_state_space(SLOW)))
    np.testing.assert_allclose(found, known, rtol=1e-9)
    assert largest_cutoff(as_state_space(SLOW), 0.9, 1) == pytest.approx(
        largest_cutoff(SLOW, 0.9, 1), rel=1e-9
    )
    for other in (models(rng)[1], SystemMatrix.diagonal([SLOW, SLOW])):
        with pytest.raises(ValueError, match="one input and one output"):
            largest_gamma(other, [1], [5.0])


def test_a_model_inverse_learns_on_a_plant_that_is_not_square(rng):
    """Three inputs, two outputs, D of full rank: one iteration removes what Q lets through."""
    A, D = np.diag([0.5, 0.3]), np.hstack((np.eye(2), np.ones((2, 1))))
    T = StateSpace(A, 0.1 * rng.standard_normal((2, 3)), np.eye(2), D, T_S)
    L = ModelInverse(T_u=T, learned=ALL_PASS)
    law = FirstOrder(L=L)
    e_0 = np.sin(np.arange(200)[:, None] * np.array([0.1, 0.2])) * np.hanning(200)[:, None] ** 2
    u = law(np.zeros((200, 3)), e_0)
    assert np.linalg.norm(e_0 - T.simulate(u)) < 1e-3 * np.linalg.norm(e_0)


def test_the_asymptotic_error_of_a_plant_that_is_not_square_is_that_of_its_iteration(rng):
    """Three outputs, two inputs, periodic records."""
    A, D = np.diag([0.5, 0.3]), np.vstack((np.eye(2), np.ones((1, 2))))
    T = StateSpace(A, np.eye(2), 0.1 * rng.standard_normal((3, 2)), D, T_S)
    e_0 = rng.standard_normal((N, 3))
    L = ModelInverse(T_u=T, learned=ALL_PASS, rate=0.5)
    omega = 2.0 * np.pi * np.fft.rfftfreq(N)
    E, G, q = np.fft.rfft(e_0, axis=0)[:, :, None], T.response(omega), LOW.response(omega)
    U = np.zeros((len(omega), 2, 1), dtype=complex)
    for _ in range(80):
        U = q[:, None, None] * (U + 0.5 * np.linalg.pinv(G) @ (E - G @ U))
    wanted = np.fft.irfft((E - G @ U)[:, :, 0], N, axis=0)
    np.testing.assert_allclose(asymptotic_error(e_0, T, L, LOW), wanted, atol=1e-9)


def test_the_asymptotic_error_of_columns_with_their_own_cutoffs(rng):
    e_0 = rng.standard_normal((N, 2))
    Q, L = ZeroPhaseButterworth((5.0, 20.0), T_S), PType(gamma=0.5, delta=1)
    alone = [
        asymptotic_error(e_0[:, [j]], SLOW, L, ZeroPhaseButterworth(f, T_S))
        for j, f in enumerate(Q.cutoff)
    ]
    matrix = SystemMatrix.diagonal([SLOW, SLOW])
    for T in (SLOW, matrix):
        np.testing.assert_allclose(asymptotic_error(e_0, T, L, Q), np.hstack(alone), atol=1e-12)


def test_an_error_of_other_columns_is_not_spread_over_the_motors():
    law = FirstOrder(L=PType(gamma=0.5))
    with pytest.raises(ValueError, match="one shape"):
        law(np.zeros((N, 2)), np.ones((N, 1)))


class WrongAdjoint:
    """Its adjoint forgets to reverse the time."""

    n_inputs = n_outputs = 1
    n_samples = N

    def simulate(self, u):
        return SLOW.simulate(u)

    def adjoint(self, e):
        return SLOW.simulate(e)


@pytest.mark.parametrize(
    "use",
    [
        lambda T: NormOptimal(T_u=T, n_samples=N, criterion=QuadraticCriterion(change=100.0)),
        lambda T: Gradient(T_u=T),
    ],
)
def test_a_users_wrong_adjoint_is_noticed(use):
    with pytest.raises(ValueError, match="simulate and adjoint do not belong"):
        use(WrongAdjoint())
