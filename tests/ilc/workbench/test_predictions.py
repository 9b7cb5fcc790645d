"""Predictions of experiments that begin elsewhere than at u = 0."""

import numpy as np
import pytest

from armside.ilc.workbench.compare import run_law
from armside.ilc.workbench.plants import Record, own_plant
from armside.ilc.workbench.words import Words

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
