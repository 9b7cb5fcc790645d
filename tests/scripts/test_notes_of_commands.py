"""A limit that changed what was asked is a line on the screen and an entry of the summary."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from armside.scripts.commands.commission import named
from armside.sim.tuning.policies import Network


def test_train_counts_the_limits_of_its_runs(armside, monkeypatch):
    """Without Stable-Baselines3: the first step of the real env."""
    ppo = ModuleType("armside.scripts.studies.ppo")

    def learn(env, steps, *, start, seed, discount, done):
        env.reset(seed=seed, options={"speed": 0.1, "radius": 0.005})
        env.step(np.tile(start, (env.num_envs, 1)).astype(np.float32))
        return Network(weights=(np.zeros((53, 3)),), biases=(start,)), []

    ppo.learn = learn  # pyright: ignore[reportAttributeAccessIssue]
    monkeypatch.setitem(sys.modules, "armside.scripts.studies.ppo", ppo)
    status, out, err = armside("train --robots 2 --steps 1 --json --out a")
    assert (err, status) == ("", 0)
    (note,) = json.loads(out)["notes"]
    assert note["cause"] == "speed"
    assert "the speed is lowered from 100 to 80.62 mm/s" in note["text"]
    assert "(in 4 of 4 runs)" in note["text"]


class TestCommission:
    def test_recordings_of_one_name_are_told_apart(self):
        given = [Path("a/run"), Path("b/run"), Path("c/mine.csv")]
        assert named(given) == {"a/run": given[0], "b/run": given[1], "mine.csv": given[2]}
        with pytest.raises(ValueError, match="the recording a/run is given twice"):
            named([given[0], given[0]])

    def test_one_of_two_recordings_of_a_name_is_left_out(self, armside):
        line = "commission --recordings a/run b/run --leave-out"
        assert "no cut 'run' to leave out. Cuts: a/run, b/run" in armside(f"{line} run").err
        assert "a/run is no recorded cut" in armside(f"{line} b/run").err
