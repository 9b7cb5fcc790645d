"""Algorithms 2 and 3: inverse of a model and norm-optimal learning, and its limits."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import lsq_linear

from armside.ilc import AllPass, Heuristic, ZeroPhaseButterworth, learn
from armside.ilc.laws.first_order import FirstOrder
from armside.ilc.laws.model_based import Beyond, ModelInverse
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.measures.norms import two_norm
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import TwoMassLoop, TwoMassPlant

from .signals import N, bump, error_norms

T_S = 0.004
T_MOTOR = TwoMassLoop().T_motor
T_ARM = TwoMassLoop().T_arm
ARX = System([0, 0, 0, 0, 0, 0.5083], [1, -0.4884], T_S)


# Algorithm 2


def test_an_exact_inverse_learns_the_passband_at_the_chosen_rate():
    reference = bump(600)
    for rate in (0.5, 1.0):
        L = ModelInverse(T_u=ARX, learned=ZeroPhaseButterworth(60.0, T_S), rate=rate)
        law = FirstOrder(L=L)
        norms = error_norms(LinearPlant(T_u=ARX, reference=reference), law, reference, 2)
        # 1 - H_B at the frequencies of the bump (below 5 Hz) is the rate
        assert norms[1] / norms[0] == pytest.approx(1 - rate, abs=0.02)


def test_the_inverse_of_coupled_motors_decouples_them():
    coupled = SystemMatrix(((ARX, ARX * 0.4), (ARX * -0.3, ARX * 0.8)))
    reference = bump(600, 2)
    L = ModelInverse(T_u=coupled, learned=ZeroPhaseButterworth(60.0, T_S))
    plant = LinearPlant(T_u=coupled, reference=reference)
    trials = list(learn(plant, FirstOrder(L=L), reference, 2))
    assert (two_norm(trials[2].error) < 1e-3 * two_norm(trials[0].error)).all()


def test_a_periodic_record_is_inverted_exactly():
    t = np.arange(500)[:, None] / 500
    wanted = np.sin(2 * np.pi * 3 * t)
    L = ModelInverse(T_u=ARX, learned=AllPass(), beyond=Beyond.PERIODIC)
    produced = ARX.simulate(np.tile(L(wanted), (3, 1)))[-500:]
    np.testing.assert_allclose(produced, wanted, atol=1e-9)


def test_an_inverse_of_an_unstable_or_misfitting_model_is_refused():
    learned = ZeroPhaseButterworth(20.0, T_S)
    with pytest.raises(ValueError, match="T_u is unstable"):
        ModelInverse(T_u=System([0, 1], [1, -1.2], T_S), learned=learned)
    with pytest.raises(ValueError, match=r"rate must be in \(0, 2\)"):
        ModelInverse(T_u=ARX, learned=learned, rate=2.0)
    L = ModelInverse(T_u=SystemMatrix.diagonal([ARX, ARX]), learned=learned)
    with pytest.raises(ValueError, match="T_u has 2 inputs, the record 3"):
        learn(LinearPlant(T_u=ARX, reference=bump(50, 3)), FirstOrder(L=L), bump(50, 3), 1)


CRITERIA = [
    QuadraticCriterion(correction=1e-4, change=1e-2),
    QuadraticCriterion(correction=1e-6, error_filter=(1.0, -0.9)),
    QuadraticCriterion(
        error=np.linspace(0, 2, N), correction=1e-3, change=np.linspace(0.1, 0.01, N)
    ),
]


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize(
    ("T_u", "tolerance"),
    # the arm's seven poles lie together at 0.985, which costs digits in any polynomial form
    [(ARX, 1e-12), (T_MOTOR, 1e-10), (T_ARM, 1e-6)],
    ids=["arx", "motor", "arm"],
)
def test_norm_optimal_minimises_its_criterion(criterion, T_u, tolerance):
    rng = np.random.default_rng(0)
    u, e = rng.standard_normal((2, N, 1))
    T = toeplitz(T_u.impulse(N), np.zeros(N))
    taps = np.asarray(criterion.error_filter)
    F = toeplitz(np.pad(taps, (0, N - len(taps))), np.zeros(N))
    We, Wu, Wd = (
        np.diag(np.broadcast_to(w, N))
        for w in (criterion.error, criterion.correction, criterion.change)
    )
    normal = T.T @ F.T @ We @ F @ T + Wu + Wd
    expected = np.linalg.solve(normal, T.T @ F.T @ We @ F @ (e + T @ u) + Wd @ u)
    law = NormOptimal(T_u=T_u, n_samples=N, criterion=criterion)
    np.testing.assert_allclose(law(u, e), expected, atol=tolerance * np.abs(expected).max())


def test_norm_optimal_takes_motors_that_disturb_each_other():
    slow = System([0, 0.1], [1, -0.9], T_S)
    T_u = SystemMatrix(((ARX, slow * 0.3), (slow * -0.2, ARX * 0.8)))
    n = 60
    T = np.block([[toeplitz(s.impulse(n), np.zeros(n)) for s in row] for row in T_u.entries])
    u, e = np.random.default_rng(1).standard_normal((2, n, 2))
    stacked_u, stacked_e = u.T.ravel(), e.T.ravel()
    expected = np.linalg.solve(
        T.T @ T + 0.011 * np.eye(2 * n), T.T @ (stacked_e + T @ stacked_u) + 0.01 * stacked_u
    )
    criterion = QuadraticCriterion(correction=1e-3, change=1e-2)
    law = NormOptimal(T_u=T_u, n_samples=n, n_columns=2, criterion=criterion)
    np.testing.assert_allclose(law(u, e).T.ravel(), expected, atol=1e-9)


def test_norm_optimal_responses_are_its_q_and_l_on_long_records():
    criterion = QuadraticCriterion(correction=1e-3, change=1e-2, error_filter=(1.0, -0.5))
    law = NormOptimal(T_u=ARX, n_samples=3000, n_columns=2, criterion=criterion)
    omega = 2 * np.pi * 12.0 * T_S
    t = np.arange(3000)
    sine = np.column_stack((np.cos(omega * t), np.sin(omega * t)))
    Q, L = (response[0] for response in law.responses(np.array([omega])))
    for u, e, expected in ((sine, 0 * sine, Q), (0 * sine, sine, Q * L)):
        got = law(u, e) @ [1, 1j]
        np.testing.assert_allclose(
            got[1000:2000], (expected * np.exp(1j * omega * t))[1000:2000], atol=1e-9
        )


def test_norm_optimal_never_lets_the_error_grow():
    plant = TwoMassPlant()
    criterion = QuadraticCriterion(change=1e-3)
    law = NormOptimal(T_u=T_MOTOR, n_samples=800, criterion=criterion)
    norms = error_norms(plant, law, plant.motor_reference, 10, output_of=lambda run: run.motor)
    assert (np.diff(norms) <= 0.0).all()
    assert norms[10] < 0.01 * norms[0]


@pytest.mark.parametrize("limit", [0.3, 0.1])
@pytest.mark.parametrize("T_u", [T_MOTOR, T_ARM], ids=["motor", "arm"])
def test_input_limits_are_kept_at_the_constrained_minimum(limit, T_u):
    n = 300
    error = bump(n)
    criterion = QuadraticCriterion(correction=1e-4, change=1e-2)
    law = Constrained(T_u=T_u, n_samples=n, criterion=criterion, limit=limit)
    u = law(np.zeros((n, 1)), error)[:, 0]
    assert np.abs(u).max() <= limit
    assert (np.abs(u) > limit - 1e-9).any()
    T = toeplitz(T_u.impulse(n), np.zeros(n))
    stacked = np.vstack((T, np.sqrt(1.01e-2) * np.eye(n)))
    target = np.concatenate((error[:, 0], np.zeros(n)))
    best = lsq_linear(stacked, target, (-limit, limit), tol=1e-14, max_iter=500)

    def cost(v):
        return np.square(stacked @ v - target).sum()

    assert cost(u) <= cost(best.x) * (1 + 1e-8)


def test_without_an_active_limit_the_constrained_law_is_norm_optimal():
    u, e = 0 * bump(), bump()
    free = NormOptimal(T_u=ARX, n_samples=N)(u, e)
    limited = Constrained(T_u=ARX, n_samples=N, limit=1.01 * np.abs(free).max())(u, e)
    np.testing.assert_array_equal(free, limited)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: QuadraticCriterion(correction=0, change=0), "must not both be 0"),
        (lambda: QuadraticCriterion(correction=-1.0), "weight of the correction must be >= 0"),
        (
            lambda: NormOptimal(
                T_u=ARX, n_samples=N, criterion=QuadraticCriterion(error=np.ones(5), change=1)
            ),
            r"weight of the error must be a number, \(90,\)",
        ),
        (lambda: Constrained(T_u=ARX, n_samples=N, limit=0.0), "limit must be > 0"),
        (lambda: Constrained(T_u=ARX, n_samples=N, limit=np.ones(7)), "limit must be a number"),
        (lambda: NormOptimal(T_u=System([0, 1], [1, -1.01], T_S), n_samples=N), "T_u is unstable"),
    ],
)
def test_criteria_and_limits_that_make_no_sense_are_refused(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def test_algorithms_2_and_3_beat_algorithm_1_on_the_two_mass_joint():
    plant = TwoMassPlant()
    Q = ZeroPhaseButterworth(17.0, 0.01)
    laws = {
        1: Heuristic(Q=Q, gamma=0.9, delta=5),
        2: FirstOrder(Q=Q, L=ModelInverse(T_u=T_MOTOR, learned=Q, regularisation=1e-6)),
        3: NormOptimal(
            T_u=T_MOTOR, n_samples=800, criterion=QuadraticCriterion(correction=1e-6, change=1e-4)
        ),
    }
    norms = {
        number: error_norms(plant, law, plant.motor_reference, 60, output_of=lambda run: run.motor)
        for number, law in laws.items()
    }
    to_5_percent = {i: int(np.argmax(values < 0.05 * values[0])) for i, values in norms.items()}
    assert to_5_percent[1] > 2 * to_5_percent[2] > 0
    assert to_5_percent[1] > 2 * to_5_percent[3] > 0
    assert norms[2][60] < norms[1][60]
    assert norms[3][60] < 0.1 * norms[1][60]
