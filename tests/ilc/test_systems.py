"""Linear systems, the plant of (7.1), and conversions from scipy and `control`."""

import json

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from armside.ilc import AllPass, Heuristic, learn
from armside.ilc.models.conversion import as_state_space, as_system
from armside.ilc.models.file import read_model, read_system
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System, tustin, zero_order_hold, zoh
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import TwoMassJoint
from armside.ilc.workbench.plants import as_model

T_S = 0.01
SYSTEM = System([0, 0, 0.5, -0.2], [1, -0.7, 0.1], T_S)


def test_response_delay_gain_and_poles_belong_to_one_system():
    assert SYSTEM.delay == 2
    assert SYSTEM.response(0.0) == pytest.approx(SYSTEM.static_gain)
    np.testing.assert_allclose(sorted(SYSTEM.poles.real), [0.2, 0.5])
    h = SYSTEM.impulse(400)
    omega = np.array([0.3, 1.0, 2.5])
    by_sum = (h * np.exp(-1j * np.outer(omega, np.arange(400)))).sum(axis=1)
    np.testing.assert_allclose(SYSTEM.response(omega), by_sum, atol=1e-12)


def test_feedback_solves_its_own_loop():
    loop = SYSTEM.feedback()
    r = np.random.default_rng(1).standard_normal((80, 1))
    y = loop.simulate(r)
    np.testing.assert_allclose(SYSTEM.simulate(r - y), y, atol=1e-12)


def test_other_models_are_refused_with_the_reason():
    with pytest.raises(ValueError, match="must be discrete with a sample time"):
        as_system(control.tf([1.0], [1.0, 1.0]))
    with pytest.raises(ValueError, match="one input and one output, got 2 and 1"):
        as_system(control.tf([[[1.0], [1.0]]], [[[1.0, 0.5], [1.0, 0.5]]], T_S))
    with pytest.raises(ValueError, match="model must be a System"):
        as_system("G")
    with pytest.raises(ValueError, match="have one sample time"):
        SYSTEM * System([1], [1], 2 * T_S)


def test_discretisations_agree_with_control():
    num, den = [3.0, 2.0], [1.0, 0.8, 5.0]
    G = control.tf(num, den)
    omega = np.linspace(0.05, 3.0, 15)
    for ours, method in ((zoh(num, den, T_S), "zoh"), (tustin(num, den, T_S), "tustin")):
        theirs = control.sample_system(G, T_S, method=method)
        np.testing.assert_allclose(
            ours.response(omega), theirs(np.exp(1j * omega)).ravel(), rtol=1e-9
        )
    with pytest.raises(ValueError, match="not causal: numerator degree 2 exceeds"):
        zoh([1.0, 0, 0], [1.0, 1.0], T_S)


def test_a_matrix_of_systems_superposes_the_responses_to_its_inputs():
    T = SystemMatrix(((SYSTEM, SYSTEM * 0.5), (SYSTEM * 0.0, SYSTEM * 2.0)))
    u = np.random.default_rng(2).standard_normal((60, 2))
    one, two = SYSTEM.simulate(u).T
    np.testing.assert_allclose(T.simulate(u), np.column_stack((one + 0.5 * two, 2 * two)))
    expected = SYSTEM.response(0.7) * np.array([[1, 0.5], [0, 2]])
    np.testing.assert_allclose(T.response(np.array([0.7]))[0], expected)


def test_the_plant_adds_reference_correction_load_and_noise_through_their_own_systems():
    rng = np.random.default_rng(3)
    r, u, w = rng.standard_normal((3, 200, 1))
    T_r, T_w, T_v = (System([0, 1 - p], [1, -p], T_S) for p in (0.5, 0.6, 0.7))
    plant = LinearPlant(
        T_u=SYSTEM, reference=r, T_r=T_r, T_w=T_w, T_v=T_v, loads=(w,), noise=0.1,
        rng=np.random.default_rng(9),
    )  # fmt: skip
    v = np.random.default_rng(9).normal(0.0, 0.1, (200, 1))
    expected = T_r.simulate(r) + SYSTEM.simulate(u) + T_w.simulate(w) + T_v.simulate(v)
    np.testing.assert_allclose(plant.run(u), expected, atol=1e-12)


def test_controlled_and_measured_variable_differ_by_the_measurement_noise():
    """Thesis (7.1), with the direct term of (7.4): noise that is fed back reaches z too."""
    rng = np.random.default_rng(3)
    r, u, w = rng.standard_normal((3, 100, 1))
    T_v, C = System([0, 0.4], [1, -0.6], T_S), System([0.3, -0.1], [1, -0.2], T_S)
    plant = LinearPlant(
        T_u=SYSTEM, reference=r, T_v=T_v, loads=(w,), noise=0.1, rng=np.random.default_rng(9), C=C
    )
    v = T_v.simulate(np.random.default_rng(9).normal(0.0, 0.1, (100, 1)))
    z, y = plant.variables(u)
    np.testing.assert_allclose(y - z, v, atol=1e-12)
    np.testing.assert_allclose(z, SYSTEM.simulate(r + u + C.simulate(r - y)) + w, atol=1e-12)


def test_the_final_error_with_a_filter_is_driven_by_reference_error_and_load():
    """Thesis (7.7): with Q = 1 both vanish."""
    n = 150
    bump = np.exp(-(((np.arange(n) - 60) / 12.0) ** 2))[:, None]
    plant = LinearPlant(T_u=SYSTEM, reference=bump, loads=(0.3 * np.roll(bump, 10),))
    law = Heuristic(Q=AllPass(), gamma=0.8, delta=2)
    *_, last = learn(plant, law, bump, 400, divergence_ratio=np.inf)
    assert np.abs(last.error[:-5]).max() < 1e-6


def test_loads_alternate_over_the_iterations():
    zero, one = np.zeros((5, 1)), np.ones((5, 1))
    plant = LinearPlant(T_u=SYSTEM, reference=zero, loads=(zero, one))
    assert [plant.run(zero)[0, 0] for _ in range(4)] == [0, 1, 0, 1]


def test_stability_is_decided_exactly_where_rounding_hides_it():
    """Roots of close, slow poles are known to a few per cent; fractions know the sign."""
    rng = np.random.default_rng(0)
    for _ in range(100):
        poles = rng.uniform(0.3, 1.1, rng.integers(1, 8))
        assert System([0, 1], np.poly(poles), T_S).is_stable == (poles.max() < 1.0)
    twelve = System([0, 1], np.poly(np.linspace(0.8, 0.96, 12)), T_S)
    assert np.abs(twelve.poles).max() < 1.01  # computed
    assert twelve.is_stable
    for edge, stable in ((1.0, False), (np.nextafter(1.0, 0.0), True)):
        assert System([0, 1], [1, -edge], T_S).is_stable is stable
        assert System([0, 1], [1, 0, edge, 0], T_S).is_stable is stable


@pytest.mark.parametrize("sample_time", [4e-3, 2.5e-4])
def test_a_transfer_function_of_states_keeps_the_digits_that_scipy_loses(sample_time):
    """Beside the response of the sampled states of the joint: see `state_space_to_system`."""
    joint = TwoMassJoint()
    A, B = zero_order_hold(*joint.state_space, sample_time)
    omega = np.geomspace(0.3, 3.0, 20)
    states = [np.linalg.solve(z * np.eye(4) - A, B)[2, 0] for z in np.exp(1j * omega)]

    def error(system):
        return np.abs(system.response(omega) / np.array(states) - 1.0).max()

    num, den, _ = signal.cont2discrete(joint.motor_transfer, sample_time)
    ours, theirs = joint.motor(sample_time), System.from_z(np.ravel(num), den, sample_time)
    assert error(ours) < 1e-11
    assert error(theirs) > 10.0 * error(ours)


RESPONDING = np.linspace(0.01, 3.1, 40)
SERVO = System([0.0, 0.4, 0.1], [1.0, -0.7, 0.2], T_S)


def slow(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(A, B, C) of n poles between 0.9 and 0.995."""
    rng = np.random.default_rng(seed)
    A = np.diag(np.linspace(0.9, 0.995, n)) + np.triu(0.02 * rng.standard_normal((n, n)), 1)
    return A, rng.standard_normal((n, 1)), rng.standard_normal((1, n))


def response(A, B, C):
    z = np.exp(1j * RESPONDING)[:, None, None]
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
    np.testing.assert_allclose(found.response(RESPONDING), SERVO.response(RESPONDING), rtol=1e-9)


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
    error = np.abs(found.response(RESPONDING) - known).max()
    largest = np.abs(StateSpace(A, B, C).response(np.linspace(0.0, np.pi, 2000))).max()
    assert error <= 1e-6 * largest


def test_eight_slow_poles_are_kept_in_state_space(tmp_path):
    A, B, C = slow(8)
    file = tmp_path / "slow.json"
    matrices = {"A": A.tolist(), "B": B.tolist(), "C": C.tolist()}
    file.write_text(json.dumps({"sample_time": T_S} | matrices), encoding="utf-8")
    for found in (read_model(file), as_model(control.ss(A, B, C, 0.0, T_S))):
        assert isinstance(found, StateSpace)
        there = found.response(RESPONDING)[:, 0, 0]
        np.testing.assert_allclose(there, response(A, B, C), rtol=1e-9)
    for refused in (lambda: read_system(file), lambda: as_system(as_state_space(found))):
        with pytest.raises(ValueError, match="keep it in state space"):
            refused()


def test_a_state_space_of_two_states_is_a_system():
    found = as_system(as_state_space(SERVO))
    np.testing.assert_allclose(found.response(RESPONDING), SERVO.response(RESPONDING), rtol=1e-9)


def test_an_integrator_is_a_system():
    assert as_system(control.ss([[1.0]], [[0.5]], [[1.0]], 0.0, T_S)).a.tolist() == [1.0, -1.0]
