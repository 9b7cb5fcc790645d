"""PPO of Stable-Baselines3 on the batched tuning env. Imported only where that is installed."""

from collections.abc import Callable
from typing import Any

import numpy as np
from stable_baselines3 import PPO  # pyright: ignore[reportMissingImports]
from stable_baselines3.common import callbacks  # pyright: ignore[reportMissingImports]

from armside.sim.tuning.policies import Network
from armside.sim.tuning.stable_baselines import Cells
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

HIDDEN = 64
"""Units of each of two layers: the default of Stable-Baselines3."""
BATCH = 160
"""Samples of a gradient step: half of a batch of 64 cells. ESTIMATE, not searched for."""
EPOCHS = 8
"""Passes over a batch; Stable-Baselines3 has 10. ESTIMATE, not searched for."""
RATE = 1e-3
"""Learning rate at first, three times that of Stable-Baselines3, as it falls to 0 at the end.
ESTIMATE, not searched for."""
GAE_LAMBDA = 0.95
"""Smoothing of the advantages: the default of Stable-Baselines3."""
LOG_STD = -1.2
"""Log standard deviation of the first actions: 0.3 in [-1, 1]."""


class _Curve(callbacks.BaseCallback):
    """Mean return of the episodes that ended in each batch."""

    def __init__(self, done: Callable[[], None]) -> None:
        super().__init__()
        self._done = done
        self.rows: list[dict[str, Any]] = []
        self._ended: list[tuple[float, bool]] = []

    def _on_training_start(self) -> None:
        self._sum = np.zeros(self.training_env.num_envs)

    def _on_step(self) -> bool:
        self._sum += self.locals["rewards"]
        for i in np.flatnonzero(self.locals["dones"]):
            self._ended.append((float(self._sum[i]), self.locals["infos"][i]["diverged"]))
            self._sum[i] = 0.0
        for _ in range(len(self._sum)):
            self._done()
        return True

    def _on_rollout_end(self) -> None:
        if self._ended:
            means = [float(np.mean(column)) for column in zip(*self._ended, strict=True)]
            row = {"steps": self.num_timesteps, "mean_return": means[0], "diverged": means[1]}
            self.rows.append(row)
            self._ended = []


def learn(
    env: IlcTuningVectorEnv,
    steps: int,
    *,
    start: np.ndarray,
    seed: int,
    discount: float,
    done: Callable[[], None] = lambda: None,
) -> tuple[Network, list[dict[str, Any]]]:
    """The network of the mean action, and the learning curve: after each batch in which episodes
    ended, how many `steps` were done, the `mean_return` of these episodes (sum of rewards: natural
    log of the tool's RMS before learning over that after) and the fraction that `diverged`.

    Args:
        env: its robots are the cells that learn; in SameStep mode.
        steps: learning iterations of ILC over all cells; ValueError unless a multiple of those of
            one episode of every cell, after each of which the network is updated.
        start: first action in every situation: in [-1, 1], of the shape of the actions.
        seed: of the first cell, the others count up from it, and of PPO's own draws.
        discount: of the reward of an iteration later.
        done: called after each learning iteration of each cell; what it raises ends the learning.
    """
    import torch  # pyright: ignore[reportMissingImports]

    torch.set_num_threads(1)
    per_batch = env.rules.iterations
    if steps % (per_batch * env.num_envs):
        raise ValueError(f"steps must be a multiple of {per_batch * env.num_envs}, got {steps}")
    model = PPO(
        "MlpPolicy",
        Cells(env, seed),
        n_steps=per_batch,
        batch_size=min(BATCH, per_batch * env.num_envs),
        n_epochs=EPOCHS,
        learning_rate=lambda left: RATE * left,  # to 0 at the end
        gamma=discount,
        gae_lambda=GAE_LAMBDA,
        ent_coef=0.0,
        policy_kwargs={"net_arch": [HIDDEN, HIDDEN], "log_std_init": LOG_STD},
        seed=seed,
        device="cpu",
    )
    # The last layer's weights are small at first: its bias is the action.
    model.policy.action_net.bias.data.copy_(torch.from_numpy(start))
    curve = _Curve(done)
    model.learn(steps, callback=curve)
    return _network(model), curve.rows


def _network(model: PPO) -> Network:
    layers = [layer for layer in model.policy.mlp_extractor.policy_net if hasattr(layer, "weight")]
    layers.append(model.policy.action_net)
    return Network(
        weights=tuple(layer.weight.detach().numpy().astype(np.float64) for layer in layers),
        biases=tuple(layer.bias.detach().numpy().astype(np.float64) for layer in layers),
    )
