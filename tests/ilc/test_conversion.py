"""Models of scipy.signal and control, and polynomials that would not hold a model."""

import json

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from armside.ilc.models.conversion import as_state_space, as_system
from armside.ilc.models.file import read_model, read_system
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System
from armside.ilc.workbench.plants import as_model

T_S = 0.01
OMEGA = np.linspace(0.01, 3.1, 40)
SERVO = System([0.0, 0.4, 0.1], [1.0, -0.7, 0.2], T_S)


def slow(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(A, B, C) of n poles between 0.9 and 0.995."""
    rng = np.random.default_rng(seed)
    A = np.diag(np.linspace(0.9, 0.995, n)) + np.triu(0.02 * rng.standard_normal((n, n)), 1)
    return A, rng.standard_normal((n, 1)), rng.standard_normal((1, n))


def response(A, B, C):
    z = np.exp(1j * OMEGA)[:, None, None]
    return (C @ np.linalg.solve(z * np.eye(len(A)) - A, B[None] + 0j))[:, 0, 0]


@pytest.mark.parametrize(
    "model",
    [
        control.tf([0.4, 0.1], [1.0, -0.7, 0.2], T_S),
        control.tf2ss(control.tf([0.4, 0.1], [1.0, -0.7, 0.2], T_S)),
        signal.dlti([0.4, 0.1], [1.0, -0.7, 0.2], dt=T_S),
        signal.dlti([0.4, 0.1], [1.0, -0.7, 0.2], dt=T_S).to_ss(),
        signal.dlti([0.4, 0.1], [1.0, -0.7, 0.2], dt=T_S).to_zpk(),
    ],
)
@pytest.mark.parametrize("taken", [as_system, as_model])
def test_discrete_models_of_every_kind_become_a_system(model, taken):
    found = taken(model)
    assert isinstance(found, System)
    np.testing.assert_allclose(found.response(OMEGA), SERVO.response(OMEGA), rtol=1e-9)


def test_a_sample_time_of_one_second_is_a_sample_time():
    assert as_system(control.tf([0.5], [1.0, -0.5], 1.0)).sample_time == 1.0


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (control.tf([0.5], [1.0, -0.5], True), "dt = True"),
        (control.tf([0.5], [1.0, 0.5], None), "dt = None"),
        (control.tf([0.5], [1.0, 0.5]), "must be discrete"),
        (signal.dlti([0.5], [1.0, -0.5], dt=True), "dt = True"),
        (signal.lti([0.5], [1.0, 0.5]), "must be discrete"),
        (signal.dlti([[0.5], [0.1]], [1.0, -0.5], dt=T_S), "got 1 and 2"),
        (control.frd([1.0, 2.0], [1.0, 2.0]), "must"),
    ],
)
def test_models_that_are_no_discrete_system_are_refused_with_the_reason(model, message):
    with pytest.raises(ValueError, match=message):
        as_system(model)


@given(n=st.integers(1, 14), seed=st.integers(0, 2**32 - 1))
def test_polynomials_hold_a_model_or_are_refused(n, seed):
    A, B, C = slow(n, seed)
    known = response(A, B, C)
    found = as_model(control.ss(A, B, C, 0.0, T_S))
    if isinstance(found, StateSpace):
        with pytest.raises(ValueError, match="keep it in state space"):
            as_system(control.ss(A, B, C, 0.0, T_S))
        return
    error = np.abs(found.response(OMEGA) - known).max()
    largest = np.abs(StateSpace(A, B, C).response(np.linspace(0.0, np.pi, 2000))).max()
    assert error <= 1e-6 * largest


def test_eight_slow_poles_are_kept_in_state_space(tmp_path):
    A, B, C = slow(8)
    file = tmp_path / "slow.json"
    matrices = {"A": A.tolist(), "B": B.tolist(), "C": C.tolist()}
    file.write_text(json.dumps({"sample_time": T_S} | matrices), encoding="utf-8")
    for found in (read_model(file), as_model(control.ss(A, B, C, 0.0, T_S))):
        assert isinstance(found, StateSpace)
        there = found.response(OMEGA)[:, 0, 0]
        np.testing.assert_allclose(there, response(A, B, C), rtol=1e-9)
    for refused in (lambda: read_system(file), lambda: as_system(as_state_space(found))):
        with pytest.raises(ValueError, match="keep it in state space"):
            refused()


def test_a_state_space_of_two_states_is_a_system():
    found = as_system(as_state_space(SERVO))
    np.testing.assert_allclose(found.response(OMEGA), SERVO.response(OMEGA), rtol=1e-9)


def test_an_integrator_is_a_system():
    assert as_system(control.ss([[1.0]], [[0.5]], [[1.0]], 0.0, T_S)).a.tolist() == [1.0, -1.0]
