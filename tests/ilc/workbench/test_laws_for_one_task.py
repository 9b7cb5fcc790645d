"""Named laws that need a task of their own, and the state of one that identifies."""

import json

import numpy as np
import pytest

from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.workbench.compare import read_states, run_law, save_states
from armside.ilc.workbench.plants import Record, model_task
from armside.ilc.workbench.task import Task

LAPS = "repetitive:period=50,cutoff=20"


@pytest.fixture
def lag(tmp_path):
    file = tmp_path / "lag.json"
    file.write_text(json.dumps({"sample_time": 0.01, "b": [0, 0.1], "a": [1, -0.9]}))
    return model_task(file, Record(n_samples=100))


def _of(model, reference):
    return lambda repetition: LinearPlant(T_u=model, reference=reference)


def test_the_repetitive_law_learns_laps_as_predicted(lag):
    laps = np.sin(2 * np.pi * np.arange(200) / 50)[:, None]
    run = run_law(Task(**(vars(lag) | {"reference": laps, "start": _of(lag.model, laps)})), LAPS, 5)
    assert run.norms[-1] < 0.6 * run.norms[0]  # the first lap, in which it settles, stays
    assert run.prediction is not None
    np.testing.assert_allclose(run.norms, run.prediction.errors, rtol=1e-6)


def test_a_law_that_identifies_goes_on_from_its_file_as_if_it_had_not_stopped(lag, tmp_path):
    whole = run_law(lag, "knob-free", 4)
    half = run_law(lag, "knob-free", 2)
    assert half.state is not None
    assert save_states(tmp_path / "state.npz", {"x": half.state}) == []
    rest = run_law(lag, "knob-free", 2, resume=read_states(tmp_path / "state.npz")["x"])
    np.testing.assert_array_equal(np.concatenate((half.norms, rest.norms)), whole.norms)
