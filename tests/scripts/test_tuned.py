"""What was searched and learned, and the claims about it for a few of their seeds."""

import json

import numpy as np
import pytest
from gymnasium.utils.seeding import np_random
from tests.claims import tuning
from tests.claims._engine import judged
from tests.claims._episodes import TUNED, searched
from tests.claims._policies import always, evaluate

from armside.scripts.studies.study import first_action, load_design
from armside.sim.laser.design import Design
from armside.sim.tuning.action import VARIABLES, Motors, action_of
from armside.sim.tuning.episode_task import TEST_SEEDS, draw
from armside.sim.tuning.policies import Network
from armside.sim.tuning.rules import Rules


def _config(name):
    return json.loads((TUNED / name).read_text())["config"]


def _individuals(rngs, n):
    return {draw("large", rng).individual for rng in rngs for _ in range(n)}


def test_no_sealed_episode_was_searched_or_learned_on():
    """Every task that the search and the training drew, drawn again."""
    sealed = _individuals(map(np.random.default_rng, TEST_SEEDS), 1)
    search, learning = _config("design.json"), _config("policy.json")
    first = search["seed"]
    seeds = range(first, first + search["episodes"])
    seen = _individuals(map(np.random.default_rng, seeds), 1)
    first = learning["seed"]
    rngs = [np_random(seed)[0] for seed in range(first, first + learning["robots"])]
    episodes = learning["steps"] // (5 * learning["robots"]) + 2
    seen |= _individuals(rngs, episodes)
    assert len(sealed) == 100
    assert len(seen) >= learning["robots"] * episodes
    assert not sealed & seen


def test_the_learned_policy_began_with_the_searched_design():
    assert _config("policy.json")["start"].endswith("tuned/design.json")
    start = first_action(TUNED / "design.json", Motors.SHARED)
    assert np.array_equal(start, action_of(searched(), Motors.SHARED))


def test_without_a_design_to_begin_with_it_is_the_middle_of_the_ranges():
    assert first_action(None, Motors.EACH).tolist() == [0.0] * 18


def test_designs_of_one_motor_or_six_are_read_from_a_search(tmp_path):
    one = {"gamma": 0.5, "delta": 4, "cutoff": 8.0}
    six = {f"{v.name}_{i}": one[v.name] + i for v in VARIABLES for i in range(1, 7)}
    file = tmp_path / "summary.json"
    file.write_text(json.dumps({"best": one | {"ratio": 0.5}}))
    assert load_design(file) == Design(gamma=(0.5,), delta=(4,), cutoff=(8.0,))
    file.write_text(json.dumps({"best": six}))
    assert load_design(file).delta == (5, 6, 7, 8, 9, 10)


@pytest.mark.parametrize("content", ["", "{}", '{"best": null}', '{"best": {"gamma": 1}}', None])
def test_a_file_without_a_design_is_refused(content, bad_input, tmp_path):
    if content is not None:
        (tmp_path / "other.json").write_text(content)
    reason = "does not exist" if content is None else "is no summary.json of armside tune"
    bad_input("train --from other.json", f"other.json {reason}")


def test_the_learned_policy_chooses_by_what_it_sees():
    policy = Network.load(TUNED / "policy.npz")
    observed = np.random.default_rng(0).uniform(-1, 1, (50, 50))
    assert policy(observed).std(axis=0).min() > 0.01


def test_the_searched_design_is_as_good_on_its_episodes_as_the_search_says():
    found = json.loads((TUNED / "design.json").read_text())
    seeds = range(found["config"]["seed"], found["config"]["seed"] + found["config"]["episodes"])
    episodes = evaluate(Rules(), seeds, always(searched(), Motors.SHARED), threads=2)
    ratio = np.exp(np.mean([np.log(e.rms_measured[-1] / e.rms_measured[0]) for e in episodes]))
    assert ratio == pytest.approx(found["best"]["ratio"], rel=1e-3)


def test_on_a_few_sealed_episodes_the_table_has_what_was_tuned_ahead_of_the_thesis():
    table = judged(tuning.CLAIM, range(4))
    ratio = {row[0]: row[1] for row in table.rows}
    assert ratio["best fixed design by search"] < 0.8 * ratio["thesis design"]
    assert ratio["learned policy"] < 0.8 * ratio["thesis design"]


def test_beyond_the_budget_the_thesis_goes_on_and_the_policy_ends():
    table = judged(tuning.CLAIM_ITERATIONS, range(3))
    rows = {name: values for name, *values in table.rows}
    assert (
        np.isfinite(rows["thesis design"]).sum()
        == np.isfinite(rows["best fixed design by search"]).sum()
        == 10
    )
    assert np.isfinite(rows["learned policy"]).sum() == 5
    gain = np.array(rows["gain γ of the learned policy, mean"])[:5]
    assert gain.argmax() == 1
