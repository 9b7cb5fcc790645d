"""Predictions of experiments that begin elsewhere than at u = 0."""

import numpy as np
import pytest

from armside.ilc.analysis.record_iteration import LiftedIteration
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.workbench.compare import run_law, setting_of
from armside.ilc.workbench.laws import build_law
from armside.ilc.workbench.plants import Record, linear, own_plant
from armside.ilc.workbench.predicted import contraction, predict
from armside.ilc.workbench.words import Words

OMEGA_NEAR = 1.0 + 1e-4 * np.tan(np.linspace(-1.57, 1.57, 20001))
"""Around a resonance [rad/sample]."""
MUTATING = """
import numpy as np

class Gaining:
    def step(self, correction, error, memory=None):
        memory = np.zeros(1) if memory is None else memory
        memory += 0.2
        return correction + memory * error, memory
"""


@pytest.fixture
def task(tmp_path):
    (tmp_path / "own.py").write_text("from armside.ilc.models.system import System\n"
        "lag = System([0, 0.1], [1, -0.9], 0.01)\n")  # fmt: skip
    (tmp_path / "laws.py").write_text(MUTATING)
    return own_plant(Words.parse(f"{tmp_path / 'own.py'}:lag"), Record(n_samples=60), 0)


def names(tmp_path):
    return ["heuristic:gamma=0.5,delta=1", "high-order", f"{tmp_path / 'laws.py'}:Gaining"]


def test_a_linear_plant_that_goes_on_does_what_is_predicted_from_its_last_run(task, tmp_path):
    for law in names(tmp_path):
        whole = run_law(task, law, 5)
        state = run_law(task, law, 2).state
        memory = np.copy(state.loop.memory) if law.endswith("Gaining") else None
        rest = run_law(task, law, 3, resume=state)
        np.testing.assert_array_equal(rest.norms, whole.norms[3:])
        np.testing.assert_allclose(rest.prediction.errors, rest.norms, rtol=1e-9)
        assert rest.prediction.contraction == whole.prediction.contraction
        if memory is not None:
            np.testing.assert_array_equal(rest.state.loop.memory, memory + 0.6)


def test_learning_from_a_correction_is_predicted_from_its_first_error(task, tmp_path):
    start = np.sin(np.linspace(0.0, 6.0, 60))[:, None]
    for law in names(tmp_path):
        run = run_law(task, law, 3, start=start)
        np.testing.assert_allclose(run.prediction.errors, run.norms, rtol=1e-9)
        assert run.norms[0] != run_law(task, law, 0).norms[0]


@pytest.mark.parametrize("law", ["d-type:delta=2,cutoff=30", "gradient", "norm-optimal"])
def test_the_criterion_that_is_printed_sees_a_narrow_resonance(law, tmp_path):
    """Damping of 1e-4 between the frequencies of a fixed grid."""
    radius, omega_0 = np.exp(-1e-4), 1.0
    a = np.array([1.0, -2.0 * radius * np.cos(omega_0), radius**2])
    b = np.convolve([0.0, 0.5], a) + 1e-3 * np.array([0.0, 1.0, -0.5, 0.0])
    plant = System(b, np.convolve([1.0, -0.5], a), 0.01)
    setting = setting_of(linear("narrow", plant, Record(n_samples=100)))
    built = build_law(law, setting)
    omega = np.sort(np.concatenate((np.linspace(1e-3, np.pi, 4000), OMEGA_NEAR)))
    if law == "norm-optimal":
        Q, L = built.responses(omega)
    else:
        Q, L = built.Q.response(omega), built.L.response(omega)
    wanted = np.abs(Q * (1.0 - L * plant.response(omega))).max()
    found = predict(law, setting, np.ones((100, 1)), 0, first_correction=np.zeros((100, 1)))
    assert found.contraction == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize(
    "law",
    ["inverse:regularisation=1e-7,cutoff=40", "norm-optimal:correction=1e-9,change=1e-6"],
)
def test_the_criterion_that_is_printed_sees_a_narrow_antiresonance(law):
    """There a model's inverse is steep, though no pole of the model is near."""
    radius, omega_0 = np.exp(-1e-4), 1.0
    zeros = np.array([1.0, -2.0 * radius * np.cos(omega_0), radius**2])
    plant = System(np.append(0.0, 0.5 * zeros / zeros.sum()), [1.0, -0.5], 0.01)
    setting = setting_of(linear("narrow", plant, Record(n_samples=100)))
    built = build_law(law, setting)
    omega = np.sort(np.concatenate((np.linspace(1e-3, np.pi, 4000), OMEGA_NEAR)))
    if law.startswith("norm-optimal"):
        Q, L = built.responses(omega)
    else:
        Q, L = built.Q.response(omega), built.L.response(omega)
    wanted = np.abs(Q * (1.0 - L * plant.response(omega))).max()
    found = predict(law, setting, np.ones((100, 1)), 0, first_correction=np.zeros((100, 1)))
    assert found.contraction == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize(
    "law", ["inverse:regularisation=1e-4,cutoff=20", "norm-optimal:correction=1e-3,change=1e-2"]
)
def test_the_criterion_of_coupled_motors_is_printed(law):
    """Beside the largest singular value of the lifted iteration, which the sup bounds."""
    one, other = ([0.0, 0.5], [1.0, -0.5]), ([0.0, 0.06], [1.0, -0.7])
    rows = ((one, other), (other, one))
    plant = SystemMatrix(tuple(tuple(System(b, a, 0.01) for b, a in row) for row in rows))
    setting = setting_of(linear("coupled", plant, Record(n_samples=300)))
    zero = np.zeros((300, 2))
    found = predict(law, setting, np.ones((300, 2)), 0, first_correction=zero).contraction
    iteration = LiftedIteration.build(plant, build_law(law, setting), 300, 2).iteration
    middle = slice(2 * 60, 2 * 240)  # away from the ends of the record, as on an infinite one
    lifted = np.linalg.norm(iteration[middle, middle], ord=2)
    assert found == pytest.approx(lifted, rel=0.02)


def test_the_criterion_of_coupled_motors_sees_their_zeros():
    """Two motors turned against two antiresonances: no entry of the model has a zero there."""
    radius, omega_0 = np.exp(-1e-4), 1.0
    zeros = np.array([1.0, -2.0 * radius * np.cos(omega_0), radius**2])
    narrow, plain = np.append(0.0, 0.5 * zeros / zeros.sum()), np.array([0.0, 0.5, 0.0, 0.0])
    c, s = np.cos(0.4), np.sin(0.4)
    entries = ((c * c, s * s), (c * s, -c * s), (c * s, -c * s), (s * s, c * c))
    systems = [System(p * narrow + q * plain, [1.0, -0.5], 0.01) for p, q in entries]
    plant = SystemMatrix((tuple(systems[:2]), tuple(systems[2:])))
    law = NormOptimal(
        T_u=plant, n_samples=100, criterion=QuadraticCriterion(correction=1e-9, change=1e-6)
    )
    Q, L = law.responses(OMEGA_NEAR)
    wanted = np.linalg.norm(Q @ (np.eye(2) - L @ plant.response(OMEGA_NEAR)), 2, axis=(1, 2)).max()
    assert wanted > 0.9
    assert contraction(law, plant) == pytest.approx(wanted, rel=1e-5)
