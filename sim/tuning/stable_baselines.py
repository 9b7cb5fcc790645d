"""The tuning env for Stable-Baselines3: many cells as its `VecEnv`, without a wrapper for each.

```python
from stable_baselines3 import PPO

cells = Cells(IlcTuningVectorEnv(8, autoreset_mode="SameStep"), seed=0)
model = PPO("MlpPolicy", cells, n_steps=5, batch_size=40).learn(4000)
```

Needs the extra [learn]: nothing else here imports this module.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv  # pyright: ignore[reportMissingImports]

from .vector_env import IlcTuningVectorEnv


class Cells(VecEnv):
    """Our vector env as a `VecEnv`.

    Observations, actions and rewards are those of `IlcTuningVectorEnv`. Where an episode ends, its
    info has `terminal_observation` and whether it `diverged`, and the next one has begun.
    """

    def __init__(self, env: IlcTuningVectorEnv, seed: int = 0) -> None:
        """
        Args:
            env: made with autoreset_mode="SameStep".
            seed: of the first reset, for the first cell; the others count up from it.

        Raises ValueError for another mode.
        """
        if env.autoreset_mode is not AutoresetMode.SAME_STEP:
            raise ValueError("Stable-Baselines3 needs an env with autoreset_mode='SameStep'")
        self._env = env  # which the next line asks for its render mode
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self._first_seed: int | None = seed

    def reset(self) -> np.ndarray:
        observed, _ = self._env.reset(seed=self._first_seed)
        self._first_seed = None
        return observed

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = np.asarray(actions, dtype=np.float32)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observed, reward, terminated, truncated, infos = self._env.step(self._actions)
        done = terminated | truncated
        each: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(done):
            # The budget is part of the task, and k is observed: the end of an episode is its end,
            # without `TimeLimit.truncated`, which would add a value beyond it.
            last, diverged = infos["final_obs"][i], bool(terminated[i])
            each[i] = {"terminal_observation": last, "diverged": diverged}
        return observed, reward.astype(np.float32), done, each

    def close(self) -> None:
        self._env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self._env, attr_name)] * len(self._indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError("the rules of the cells are fixed")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        raise NotImplementedError("the cells have no methods of their own")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * len(self._indices(indices))

    def _indices(self, indices: Any) -> Sequence[int]:
        return range(self.num_envs) if indices is None else np.atleast_1d(indices).tolist()
