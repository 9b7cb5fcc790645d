"""State-space models, fixed or along the record, and files of models."""

from typing import Any

import control
import numpy as np
import pytest
from scipy import signal

from armside.ilc.analysis import asymptotic_error
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.first_order import MatrixGain
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.conversion import as_state_space
from armside.ilc.models.file import MOST_STATES, read_model, write_model
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace, TimeVarying
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

from .random_cases import T_S, random_matrix
from .signals import bump, error_norms

OMEGA = np.array([0.0, 0.01, 0.4, 2.0, np.pi])


def varying(n_samples, n=2):
    """Lags whose poles drift along the record; gain 1 at rest."""
    pole = np.linspace(0.5, 0.8, n_samples)[:, None, None] * np.eye(n)
    C = np.broadcast_to(np.eye(n), pole.shape)
    return TimeVarying(pole, np.eye(n) - pole, C)


def test_a_plant_that_varies_along_the_record_is_learned():
    reference, T_u = bump(200, 2), varying(200)
    plant = LinearPlant(T_u=T_u, reference=reference)
    np.testing.assert_allclose(plant.run(0.0 * reference), T_u.simulate(reference))
    norms = error_norms(plant, NormOptimal(T_u=T_u, n_samples=200), reference, 3)
    assert norms[-1] < 1e-3 * norms[0]
    longer = LinearPlant(T_u=varying(150), reference=reference)
    with pytest.raises(ValueError, match="T_u covers 150 samples, the record 200"):
        longer.run(np.zeros((200, 2)))


@pytest.mark.parametrize("n", [1, 2, 6])
def test_coupled_motors_are_written_and_read_with_the_same_response(n, tmp_path):
    T = random_matrix(np.random.default_rng(n), n, 3, 0.9, 0.05)
    file = tmp_path / "plant.json"
    write_model(file, SystemMatrix(((T,),)) if isinstance(T, System) else T)
    found = read_model(file)
    assert found.sample_time == T_S
    expected = T.response(OMEGA)
    np.testing.assert_allclose(found.response(OMEGA), expected, atol=1e-9 * abs(expected).max())


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (random_matrix(np.random.default_rng(0), 5, 14, 0.9, 0.5), f"at most {MOST_STATES} states"),
        (varying(50), "model must be a System, a StateSpace, .* got TimeVarying"),
    ],
    ids=["large", "varying"],
)
def test_a_model_that_could_not_be_read_is_not_written(model, message, tmp_path):
    with pytest.raises(ValueError, match=message) as refused:
        write_model(tmp_path / "plant.json", model)
    assert "\n" not in str(refused.value)
    assert not any(tmp_path.iterdir())


def test_a_model_that_is_not_square_is_written_and_refused_as_a_plant(tmp_path):
    file = tmp_path / "plant.json"
    write_model(file, StateSpace(np.eye(1) / 2, np.ones((1, 2)), np.ones((1, 1))))
    with pytest.raises(ValueError, match="as many outputs as inputs are needed, got 1 and 2"):
        read_model(file)


def test_response_and_asymptotic_error_are_those_of_the_matrix_of_systems():
    one, other = (
        System.from_z([0.3], [1, -0.7], T_S),
        System.from_z([0.1, 0.1], [1, -1.2, 0.5], T_S),
    )
    matrix = SystemMatrix(((one, other * 0.2), (one * -0.1, other)))
    T = as_state_space(matrix)
    np.testing.assert_allclose(T.response(OMEGA), matrix.response(OMEGA), atol=1e-12)
    Q = ZeroPhaseButterworth(20.0, T_S)
    L = MatrixGain(gamma=0.5 * np.eye(2), delta=2)
    e_0 = np.random.default_rng(0).standard_normal((100, 2))
    limit = asymptotic_error(e_0, T, L, Q)
    np.testing.assert_allclose(limit, asymptotic_error(e_0, matrix, L, Q), atol=1e-10)


def test_models_of_scipy_and_control_keep_their_response():
    continuous = control.rss(4, 2, 3)
    sampled: Any = control.c2d(continuous, T_S)
    expected = np.moveaxis(sampled(np.exp(1j * OMEGA[1:])), 2, 0)
    for found in (as_state_space(continuous, T_S), as_state_space(sampled)):
        np.testing.assert_allclose(found.response(OMEGA[1:]), expected, atol=1e-9)
    ratio: Any = control.tf(
        [[[1.0, 0.2], [1.0]], [[0.3], [1.0, 0.0]]],
        [[[1.0, -0.5, 0.06], [1.0, -0.7]], [[1.0, -0.2], [1.0, -0.9]]],
        T_S,
    )
    expected = np.moveaxis(ratio(np.exp(1j * OMEGA)), 2, 0)
    np.testing.assert_allclose(as_state_space(ratio).response(OMEGA), expected, atol=1e-12)
    lag: Any = signal.lti([2.0], [1.0, 3.0])
    pole = np.exp(-3.0 * T_S)
    expected = 2.0 / 3.0 * (1.0 - pole) / (np.exp(1j * OMEGA) - pole)
    np.testing.assert_allclose(as_state_space(lag, T_S).response(OMEGA)[:, 0, 0], expected)


class Own:
    """Plant of a user: a delay of one sample, by its products alone."""

    n_inputs = n_outputs = 1

    def simulate(self, signal, /):
        return np.vstack((np.zeros((1, 1)), signal[:-1]))

    def adjoint(self, signal, /):
        return np.vstack((signal[1:], np.zeros((1, 1))))


def test_a_model_of_ones_own_learns_by_its_products_or_is_refused():
    e = np.random.default_rng(0).standard_normal((50, 1))
    law = NormOptimal(T_u=Own(), n_samples=50, criterion=QuadraticCriterion(change=0.25))
    expected = np.vstack((e[1:], [[0.0]])) / 1.25
    np.testing.assert_allclose(law(np.zeros((50, 1)), e), expected, atol=1e-8)
    with pytest.raises(ValueError, match="n_inputs, n_outputs, simulate and adjoint"):
        NormOptimal(T_u=object(), n_samples=50)  # pyright: ignore[reportArgumentType]
    weights = np.ones(50)
    weights[7] = 0.0
    with pytest.raises(ValueError, match="whose sum is > 0"):
        NormOptimal(T_u=Own(), n_samples=50, criterion=QuadraticCriterion(change=weights))
