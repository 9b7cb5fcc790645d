"""Files with models of T_u, written and read again, and plants of models along the record."""

import numpy as np
import pytest

from armside.ilc.laws.norm_optimal import NormOptimal
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


def test_a_plant_that_varies_along_the_record_is_learned():
    reference = bump(200, 2)
    T_u = varying(200)
    plant = LinearPlant(T_u=T_u, reference=reference)
    np.testing.assert_allclose(plant.run(0.0 * reference), T_u.simulate(reference))
    norms = error_norms(plant, NormOptimal(T_u=T_u, n_samples=200), reference, 3)
    assert norms[-1] < 1e-3 * norms[0]


def test_a_plant_along_another_record_is_refused_in_one_line():
    plant = LinearPlant(T_u=varying(150), reference=bump(200, 2))
    with pytest.raises(ValueError, match="T_u covers 150 samples, the record 200"):
        plant.run(np.zeros((200, 2)))
    with pytest.raises(ValueError, match="direct term C needs a T_u with one input"):
        LinearPlant(T_u=varying(200), reference=bump(200, 2), C=System(np.ones(1), np.ones(1), T_S))
    with pytest.raises(ValueError, match="T_u must be a model with"):
        LinearPlant(T_u=object(), reference=bump(200))  # pyright: ignore[reportArgumentType]
