"""The extra [learn]: the env under Stable-Baselines3, and the training script."""

import json
import threading
from contextlib import closing

import gymnasium
import numpy as np
import pytest
from tests.claims._policies import run_episode

import armside.sim.tuning  # noqa: F401 - registers the env
from armside import assets
from armside.scripts import cli
from armside.sim.tuning.episode_task import TEST_SEEDS
from armside.sim.tuning.policies import Network
from armside.sim.tuning.rules import Rules

TWO_LINK = assets.LARGE_ROBOT_XML.with_name("two_link.toml")
pytest.importorskip("stable_baselines3", reason="needs the extra [learn]", exc_type=ImportError)


@pytest.mark.parametrize("version", [0, 1])
def test_the_env_checker_of_stable_baselines3_has_nothing_to_say(version):
    from stable_baselines3.common.env_checker import check_env  # pyright: ignore[reportMissingImports]

    # Warnings are errors in this suite.
    check_env(gymnasium.make(f"armside/IlcTuning-v{version}", render_mode="rgb_array").unwrapped)


def test_training_writes_a_policy_that_runs_without_torch(tmp_path):
    out = tmp_path / "a"
    line = f"train --robots 4 --steps 41 --quiet --out {out}"
    assert cli.main(line.split()) == 0
    network = Network.load(out / "policy.npz")
    summary = json.loads((out / "summary.json").read_text())
    curve = summary["curve"]
    assert summary["config"]["steps"] == 41
    assert summary["steps"] == curve[-1]["steps"] == 60
    assert np.isfinite([row["mean_return"] for row in curve]).all()
    episode = run_episode(Rules(iterations=1, version=1), 0, network)
    assert np.isfinite(episode.rms_true).all()


def test_a_policy_of_corrections_is_trained(tmp_path):
    words = "--robot two_link --action correction --functions 4 --robots 2 --steps 20 --quiet"
    line = words.replace("two_link", str(TWO_LINK)).split()
    assert cli.main(["train", *line, "--out", str(tmp_path / "a")]) == 0
    network = Network.load(tmp_path / "a" / "policy.npz")
    assert network.biases[-1].shape == (2 * 4,)


def test_the_arrays_are_the_mean_action_of_the_model(tmp_path):
    from stable_baselines3 import PPO  # pyright: ignore[reportMissingImports]

    from armside.scripts.studies.ppo import _network
    from armside.sim.tuning.stable_baselines import Cells
    from armside.sim.tuning.vector_env import IlcTuningVectorEnv

    env = IlcTuningVectorEnv(2, autoreset_mode="SameStep")
    model = PPO("MlpPolicy", Cells(env, 0), n_steps=5, batch_size=10, seed=0, device="cpu")
    observed = np.random.default_rng(0).uniform(-1, 1, (20, 50)).astype(np.float32)
    action, _ = model.predict(observed, deterministic=True)
    assert _network(model)(observed) == pytest.approx(action, abs=1e-5)  # float32 inside
    env.close()


def test_the_learning_rate_falls_to_zero_and_not_below():
    from armside.scripts.studies import ppo
    from armside.sim.tuning.vector_env import IlcTuningVectorEnv

    with closing(IlcTuningVectorEnv(2, autoreset_mode="SameStep")) as env:
        rates = []

        class Watched(ppo.PPO):
            def train(self):
                super().train()
                rates.append(self.policy.optimizer.param_groups[0]["lr"])

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(ppo, "PPO", Watched)
            ppo.learn(env, 20, start=np.zeros(3, np.float32), seed=0, discount=1.0)
        assert rates == pytest.approx([ppo.RATE / 2, 0.0])
        with pytest.raises(ValueError, match="steps must be a multiple of 10, got 11"):
            ppo.learn(env, 11, start=np.zeros(3, np.float32), seed=0, discount=1.0)


def test_training_ends_its_threads_when_it_fails(tmp_path, monkeypatch):
    from armside.scripts.studies import ppo

    def broken(*args, **options):
        raise RuntimeError("no policy")

    monkeypatch.setattr(ppo, "_network", broken)
    known = set(threading.enumerate())
    assert cli.main(f"train --robots 2 --steps 10 --out {tmp_path / 'a'}".split()) == 1
    assert set(threading.enumerate()) == known


def test_training_refuses_the_sealed_seeds(tmp_path, capsys):
    line = f"train --robots 4 --steps 20 --seed {TEST_SEEDS[0] - 2} --out {tmp_path / 'a'}"
    assert cli.main(line.split()) == 2
    assert "sealed test seeds" in capsys.readouterr().err
    assert not (tmp_path / "a").exists()
