"""Plants and laws by name, predictions beside results, and state on disk."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from armside.ilc.laws.wrappers import Best
from armside.ilc.learning import LoopState
from armside.ilc.models.file import read_model
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace
from armside.ilc.workbench.compare import RunState, read_states, run_law, save_states, setting_of
from armside.ilc.workbench.exchange import Folder
from armside.ilc.workbench.laws import LAWS, build_law
from armside.ilc.workbench.own import OwnCodeError
from armside.ilc.workbench.plants import Record, joint, model_task, own_plant
from armside.ilc.workbench.signals import named_reference, read_signal, write_signal
from armside.ilc.workbench.task import Task, along_path
from armside.ilc.workbench.words import Words, guessed

OWN = '''
import numpy as np

class Lag:
    """y = 0.9 y + 0.1 (r + u), with noise."""
    sample_time = 0.01
    def __init__(self, rng, noise=1e-3):
        self.rng, self.noise = rng, noise
    def run(self, correction):
        y, x = np.zeros(len(correction)), 0.0
        for i, u in enumerate(correction[:, 0]):
            y[i] = x + self.noise * self.rng.normal()
            x = 0.9 * x + 0.1 * (1.0 + u)
        return y

class Broken(Lag):
    def run(self, correction):
        return {}["log"]

class Counting:
    def step(self, u, e, memory=None):
        n = 0 if memory is None else memory["n"]
        return u + 0.5 / (1 + n) * e, {"n": n + 1}

def half(u, e):
    return u + 0.5 * e

def wrong(u, e):
    return u[:-1]
'''
REQUIRED = {
    "constrained": ":limit=5",
    "adaptive": ":noise=0.01,disturbance=0.1",
    "point-to-point": ":times=0.2/0.4/0.6/0.8",
    "kalman": ":noise=0.01",
    "repetitive": ":period=25",
}


@pytest.fixture
def own(tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


@pytest.fixture
def lag(tmp_path):
    file = tmp_path / "lag.json"
    file.write_text(json.dumps({"sample_time": 0.01, "b": [0, 0.1], "a": [1, -0.9]}))
    return model_task(file, Record(n_samples=100))


@pytest.mark.parametrize("name", [name for name in LAWS if name != "repetitive"])
def test_every_named_law_reduces_the_error_of_a_lag_as_predicted(name, lag):
    run = run_law(lag, name + REQUIRED.get(name, ""), 5)
    assert not run.diverged
    assert run.norms[-1] < 0.9 * run.norms[0]
    assert run.prediction is not None
    np.testing.assert_allclose(run.norms, run.prediction.errors, rtol=1e-6, atol=1e-9)


def test_a_prediction_of_a_wrong_model_is_not_the_result(tmp_path, lag):
    run = run_law(
        Task(**(vars(lag) | {"model": 0.5 * lag.model})), "heuristic:gamma=0.5,delta=1", 5
    )
    assert run.prediction is not None
    assert abs(run.prediction.errors[-1] - run.norms[-1]) > 0.05 * run.norms[-1]


def test_the_joint_takes_the_users_stiffness():
    stiff = run_law(joint(Words.parse("two-mass:k=10"), Record()), "heuristic", 1)
    soft = run_law(joint(Words.parse("two-mass:k=4"), Record()), "heuristic", 1)
    assert stiff.measures[0]["arm"] < soft.measures[0]["arm"]


def test_a_state_space_is_its_transfer_function_in_json_and_mat(tmp_path):
    A, B, C = [[0.9, 0.0], [0.0, 0.5]], [[0.1, 0.0], [0.0, 0.5]], [[1.0, 0.0], [0.2, 1.0]]
    content = {"sample_time": 0.01, "A": A, "B": B, "C": C}
    (tmp_path / "m.json").write_text(json.dumps(content))
    savemat(tmp_path / "m.mat", content)
    one, other = read_model(tmp_path / "m.json"), read_model(tmp_path / "m.mat")
    assert isinstance(one, StateSpace)
    omega = np.array([0.1, 1.0, 3.0])
    z = np.exp(1j * omega)[:, None, None]
    exact = np.array(C) @ np.linalg.inv(z * np.eye(2) - np.array(A)) @ np.array(B)
    np.testing.assert_allclose(one.response(omega), exact, rtol=1e-12)
    np.testing.assert_array_equal(one.response(omega), other.response(omega))


@pytest.mark.parametrize(
    "law", ["own.py:half", "own.py:Counting", "high-order", "heuristic:gamma=0.5"]
)
def test_five_and_five_more_updates_are_ten_at_once(law, own, tmp_path):
    task = own_plant(Words.parse(f"{own}:Lag"), Record(n_samples=60), seed=3)
    law = law.replace("own.py", str(own))
    at_once = run_law(task, law, 10, noise=0.01, seed=3)
    first = run_law(task, law, 5, noise=0.01, seed=3)
    assert first.state is not None
    save_states(tmp_path / "state.npz", {"a": first.state})
    more = run_law(
        task, law, 5, noise=0.01, seed=3, resume=read_states(tmp_path / "state.npz")["a"]
    )
    assert more.first_k == 6
    np.testing.assert_array_equal(np.concatenate((first.norms, more.norms)), at_once.norms)
    np.testing.assert_array_equal(more.correction, at_once.correction)


def test_a_stored_memory_comes_back_and_an_odd_one_is_named(tmp_path):
    best = Best(np.ones((2, 1)), np.zeros((2, 1)), 0.5, 1.0, 2)
    memory = (best, {"n": 3, 2: [1.5, None, "x"]}, (np.arange(3),))
    loop = LoopState(4, np.ones((2, 1)), np.ones((2, 1)), memory, np.ones(1))
    odd = LoopState(4, np.ones((2, 1)), np.ones((2, 1)), object(), np.ones(1))
    states = {"good": RunState(loop=loop), "odd": RunState(loop=odd)}
    assert save_states(tmp_path / "s.npz", states) == ["odd"]
    read = read_states(tmp_path / "s.npz")
    assert read["odd"] is None
    assert read["good"] is not None
    again = read["good"].loop.memory
    assert isinstance(again[0], Best)
    assert again[0].setbacks == 2
    assert again[1] == memory[1]
    np.testing.assert_array_equal(again[2][0], np.arange(3))


def test_an_error_in_a_users_file_names_file_line_and_error(own):
    task = own_plant(Words.parse(f"{own}:Broken"), Record(n_samples=60), seed=0)
    line = 1 + OWN[: OWN.index("return {}")].count("\n")
    with pytest.raises(OwnCodeError, match=rf"own\.py, line {line}: KeyError: 'log'"):
        run_law(task, "heuristic", 1)
    with pytest.raises(OwnCodeError, match=r"must have shape \(60, 1\), got \(59, 1\)"):
        run_law(own_plant(Words.parse(f"{own}:Lag"), Record(n_samples=60), 0), f"{own}:wrong", 1)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("heuristc", "Unknown law 'heuristc'. Did you mean heuristic"),
        ("heuristic:gain=1", "Unknown parameter 'gain'"),
        ("heuristic:gamma=fast", "gamma must be a finite number, got 'fast'"),
        ("heuristic:delta=1.5", "delta must be a whole number"),
        ("heuristic:gamma", "key=value"),
        ("constrained", "needs limit=NUMBER"),
        ("nowhere.py:Law", "nowhere.py is no Python file"),
    ],
)
def test_words_that_name_no_law_are_refused(words, message, lag):
    with pytest.raises(ValueError, match=message):
        build_law(words, setting_of(lag))


def test_by_hand_in_a_folder_equals_the_plant_in_process_bit_for_bit(tmp_path, lag):
    law = build_law("high-order:delta=1", setting_of(lag))
    in_process = run_law(lag, "high-order:delta=1", 4)
    folder, plant = Folder(tmp_path, lag.sample_time), lag.start(0)
    for k in range(5):  # each a fresh process: only files remain
        assert folder.advance(law, lag.reference, 4).k == k
        u = read_signal(folder.correction(k)).values
        write_signal(folder.output(k), plant.run(u), lag.sample_time, "y")
    state = folder.advance(law, lag.reference, 4)
    assert state.k == 5
    np.testing.assert_array_equal(state.corrections[4], in_process.correction)


def test_a_log_at_another_rate_is_interpolated_and_a_short_one_refused(tmp_path):
    time = np.arange(0.0, 1.0, 0.004)
    lines = "\n".join(f"{5.0 + t!r},{t!r}" for t in time.tolist())
    (tmp_path / "y.csv").write_text("time [s],y\n" + lines)
    at = read_signal(tmp_path / "y.csv").at(100, 0.01)
    np.testing.assert_allclose(at[:99, 0], np.arange(99) * 0.01, atol=1e-12)
    with pytest.raises(ValueError, match="too short"):
        read_signal(tmp_path / "y.csv").at(200, 0.01)


def test_damaged_logs_are_refused_in_a_sentence(tmp_path):
    rng, good = np.random.default_rng(0), b"time,y\n" + b"".join(b"%d,0.5\n" % i for i in range(9))
    file: Path = tmp_path / "y_0.csv"
    said = []
    for _ in range(200):
        content = bytearray(good)
        for _ in range(rng.integers(1, 6)):
            content[rng.integers(len(content))] = rng.integers(256)
        file.write_bytes(bytes(content[: rng.integers(1, len(content) + 1)]))
        try:
            assert np.isfinite(read_signal(file).at(9, 1.0)).all()
        except ValueError as error:
            said.append(str(error))
    assert len(said) > 50
    assert all("y_0.csv" in each and "\n" not in each for each in said)


@pytest.mark.parametrize("name", ["step", "ramp"])
def test_references_move_from_zero_to_one(name):
    r = named_reference(name, 100, 2, 0.01)
    assert r.shape == (100, 2)
    assert abs(r[0]).max() == 0.0
    np.testing.assert_allclose(r[-1], 1.0, atol=0.03)


def test_a_correction_is_carried_over_by_its_place_on_the_path():
    place = np.array([0.0, 0.0, 1.0, 2.0, 3.0, 3.0])
    correction = np.array([9.0, 0.0, 2.0, 4.0, 6.0, 9.0])[:, None]
    carried = along_path(correction, place, np.array([-1.0, 0.5, 2.5, 4.0]))
    np.testing.assert_allclose(carried[:, 0], [0.0, 1.0, 5.0, 6.0])


@pytest.mark.parametrize("place", [[0.0, 2.0, 1.0], [0.0, np.nan, 1.0], [0.0, 1.0]])
def test_places_that_cannot_be_on_a_path_are_refused(place):
    with pytest.raises(ValueError, match="place must be 3 numbers"):
        along_path(np.ones((3, 1)), np.array(place), np.array([0.5]))


LAPS = "repetitive:period=50,cutoff=20"


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


def test_a_correction_learned_at_rest_is_that_of_its_end_of_the_rest():
    """Before the path the last sample of the rest counts, on it the first."""
    correction, place = np.arange(1.0, 7.0)[:, None], np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    found = along_path(correction, place, np.array([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(found[:, 0], [2.0, 2.0, 2.5, 3.0, 5.0, 5.0])


def test_words_without_a_type_are_whole_numbers_numbers_or_text():
    found = guessed({"delta": "5", "gain": "0.9", "small": "1e-3", "name": "5 Hz"})
    assert found == {"delta": 5, "gain": 0.9, "small": 0.001, "name": "5 Hz"}
    assert [type(value) for value in found.values()] == [int, float, float, str]
