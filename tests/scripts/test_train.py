"""Learning as far as it works without the extra [learn]."""

import importlib.util
import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from armside.scripts.commands.train import TrainCfg
from armside.scripts.studies.study import whole_batches
from armside.sim.tuning.episode_task import RANGES
from armside.sim.tuning.policies import Network


def _network(rng):
    sizes = (50, 8, 8, 3)
    pairs = list(pairwise(sizes))
    return Network(
        weights=tuple(rng.standard_normal((n, m)) for m, n in pairs),
        biases=tuple(rng.standard_normal(n) for _, n in pairs),
    )


def test_a_policy_survives_its_file(tmp_path):
    rng = np.random.default_rng(0)
    network, observed = _network(rng), rng.uniform(-1, 1, 50)
    network.save(tmp_path / "policy.npz")
    again = Network.load(tmp_path / "policy.npz")
    assert np.array_equal(again(observed), network(observed))


def test_actions_lie_in_the_action_space_for_one_observation_or_many():
    rng = np.random.default_rng(1)
    network, observed = _network(rng), rng.uniform(-1, 1, (7, 50)).astype(np.float32)
    actions = network(observed)
    assert actions.shape == (7, 3)
    assert actions.dtype == np.float32
    assert np.abs(actions).max() <= 1.0
    assert actions[2] == pytest.approx(network(observed[2]))


def test_a_policy_is_trained_on_a_reward_that_looks_past_the_last_update():
    rules = TrainCfg().rules
    assert rules.version == 1
    assert rules.shapes.radius == RANGES[1].radius
    assert replace(TrainCfg(), radius=(5.0,)).rules.shapes.radius == (0.005, 0.005)


def test_a_file_that_is_no_policy_is_refused(tmp_path):
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match="is not a policy"):
        Network.load(tmp_path / "other.npz")


@pytest.mark.parametrize(
    ("steps", "batch", "done"), [(1, 320, 320), (19200, 320, 19200), (12800, 35, 12810)]
)
def test_steps_are_rounded_up_to_whole_batches(steps, batch, done):
    assert whole_batches(steps, batch) == done


@pytest.mark.skipif(
    importlib.util.find_spec("stable_baselines3") is not None, reason="the extra is installed"
)
def test_without_the_extra_training_says_what_to_install(bad_input):
    said = "armside: armside train needs Stable-Baselines3: pip install 'armside[learn]'\n"
    bad_input("train --steps 1", said)


def test_a_folder_that_cannot_be_made_is_found_before_learning(bad_input, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    bad_input("train --out a", "no folder can be made in")
