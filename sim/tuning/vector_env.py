"""Many robot cells at once: the same episodes as the single env, rolled out on all cores.

Each robot's run is one rollout of the physics. Rollouts release Python's lock, so as many go on at
once as there are cores, and what Python has to do for one robot is done while another one moves.
Records differ in length with the speed: one common rollout would pad all to the longest.
"""

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any, TypeVar

import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..notes import Note, Tally
from ..robot.run import cores
from .episode_task import whole
from .rules import Decision, Rules, Step, show_compilation
from .situation import Situation

Result = TypeVar("Result")


class IlcTuningVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """`num_envs` copies of the env; row i is bitwise what the single env returns.

    `gymnasium.make_vec(..., vectorization_mode="vector_entry_point")` makes it. Episodes that are
    over start again by themselves, at the next step as Gymnasium does by default, or as
    `autoreset_mode` says.

    Observations and actions (num_envs, ...) float32 as of the single env, rewards (num_envs,)
    float64, ends (num_envs,) bool.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        threads: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: None = None,
        **options: Any,
    ) -> None:
        """
        Args:
            threads: robots that run at the same time; all cores if None.
            autoreset_mode: NextStep, SameStep or Disabled; sealed episodes, whose seeds are given,
                need Disabled.
            options: fields of `armside.sim.tuning.rules.EnvCfg`.

        Raises ValueError as the single env does.
        """
        self.num_envs = whole("num_envs", num_envs, 1)
        self.threads = cores() if threads is None else whole("threads", threads, 1)
        if render_mode is not None:
            raise ValueError(f"the vector env draws nothing, got render_mode {render_mode!r}")
        show_compilation()
        self.rules = Rules(**options)
        self.render_mode = None
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            known = ", ".join(mode.value for mode in AutoresetMode)
            refused = f"Unknown autoreset_mode {autoreset_mode!r}. It can be: {known}"
            raise ValueError(refused) from None
        if self.rules.sealed and self.autoreset_mode is not AutoresetMode.DISABLED:
            raise ValueError(
                "a sealed env cannot start episodes by itself: give autoreset_mode='Disabled'"
            )
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.single_action_space = self.rules.action_space
        self.single_observation_space = self.rules.observation_space
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._rngs: list[np.random.Generator | None] = [None] * self.num_envs
        self._situations: list[Situation | None] = [None] * self.num_envs
        self._over = np.zeros(self.num_envs, dtype=bool)
        self.tally = Tally()
        """Notes of the runs of all robots since the env was made."""
        self._pool = ThreadPoolExecutor(self.threads)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Reset all robots, or those of the boolean array options["reset_mask"].

        seed: of the first robot, the others count up from it, or one for each. Other options are
        those of the single env and hold for all robots.

        Raises ValueError as the single env does, and for seeds or a mask that do not fit; the env
        is then as if it had not been asked.
        """
        seeds = self._seeds(seed)
        if not isinstance(options, Mapping | None):
            raise ValueError(f"options of reset must be a dict, got {options!r}")
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        mask = np.ones(self.num_envs, dtype=bool) if mask is None else np.asarray(mask)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise ValueError(f"reset_mask must be {self.num_envs} booleans, one of them true")
        chosen: list[int] = np.flatnonzero(mask).tolist()
        rngs: dict[int, np.random.Generator] = {}
        for i in chosen:
            seed_i, known = self.rules.check_seed(seeds[i]), self._rngs[i]
            if known is None or seed_i is not None:
                known, _ = np_random(seed_i)
            rngs[i] = copy.deepcopy(known)
        tasks = {i: self.rules.draw(rngs[i], options) for i in chosen}
        observations = np.zeros(self.observation_space.shape, np.float32)  # type: ignore[arg-type]
        infos: dict[str, Any] = {}
        begun = dict(self._all(lambda i: self.rules.begin(tasks[i]), chosen))
        for i, situation in begun.items():
            infos = self._add_info(infos, self.rules.info(situation), i)
            self._rngs[i], self._situations[i], self._over[i] = rngs[i], situation, False
        self._count(chosen)
        for i, situation in enumerate(self._situations):
            if situation is not None:
                observations[i] = self.rules.observe(situation)
        return observations, infos

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One iteration of each robot, in parallel.

        Raises:
            ValueError: as the single env does, with the number of the robot.
            RuntimeError: before `reset`; or without autoreset, while episodes are over.
        """
        actions = np.asarray(actions)
        if actions.shape != self.action_space.shape:
            raise ValueError(
                f"actions must have shape {self.action_space.shape}, got {actions.shape}"
            )
        if any(situation is None for situation in self._situations):
            raise RuntimeError("call reset before the first step")
        anew = self._over.copy()
        if anew.any() and self.autoreset_mode is not AutoresetMode.NEXT_STEP:
            raise RuntimeError("episodes are over: reset them with options['reset_mask']")
        decisions = [None if anew[i] else self._decision(i, a) for i, a in enumerate(actions)]
        same_step = self.autoreset_mode is AutoresetMode.SAME_STEP
        observations = np.empty(self.observation_space.shape, np.float32)  # type: ignore[arg-type]
        rewards = np.empty(self.num_envs)
        terminated, truncated = (np.empty(self.num_envs, dtype=bool) for _ in range(2))
        infos: dict[str, Any] = {}
        for i, step in self._all(lambda i: self._next(i, decisions[i]), range(self.num_envs)):
            observations[i], rewards[i], terminated[i], truncated[i], info = step
            self._over[i] = terminated[i] or truncated[i]
            if self._over[i] and same_step:
                info = {"final_obs": step[0], "final_info": info}
            infos = self._add_info(infos, info, i)
        self._count(range(self.num_envs))
        if same_step:
            over: list[int] = np.flatnonzero(self._over).tolist()
            for i, begun in self._all(self._start, over):
                observations[i] = begun[0]
                infos = self._add_info(infos, begun[4], i)
            self._count(over)
            self._over[:] = False
        return observations, rewards, terminated, truncated, infos

    @property
    def situations(self) -> list[Situation]:
        """Situation of each robot's episode."""
        return [situation for situation in self._situations if situation is not None]

    @property
    def notes(self) -> list[Note]:
        """Limits that changed the runs of all robots since the env was made, with their number."""
        return self.tally.notes("runs")

    @property
    def episodes_over(self) -> np.ndarray:
        """(num_envs,) bool."""
        return self._over.copy()

    def close_extras(self, **kwargs: Any) -> None:
        """Stop the threads."""
        self._pool.shutdown()

    def _decision(self, i: int, action: np.ndarray) -> Decision:
        try:
            return self.rules.decision(action)
        except ValueError as error:
            raise ValueError(f"robot {i}: {error}") from None

    def _start(self, i: int) -> Step:
        """A new episode of robot i, as the step that follows the end of one."""
        rng = self._rngs[i]
        assert rng is not None
        situation = self.rules.begin(self.rules.draw(rng))
        self._situations[i] = situation
        return self.rules.observe(situation), 0.0, False, False, self.rules.info(situation)

    def _next(self, i: int, decision: Decision | None) -> Step:
        """One iteration of robot i; without a decision, a new episode."""
        if decision is None:
            return self._start(i)
        before = self._situations[i]
        assert before is not None
        after = self.rules.advance(before, decision)
        self._situations[i] = after
        return self.rules.step(before, after, decision)

    def _all(
        self, function: Callable[[int], Result], robots: Sequence[int]
    ) -> Iterator[tuple[int, Result]]:
        """(i, function of robot i), on the threads, as they are done; longest record first."""
        if self.closed:
            raise RuntimeError("this env is closed")
        futures = {self._pool.submit(function, i): i for i in sorted(robots, key=self._order)}
        for future in as_completed(futures):
            yield futures[future], future.result()

    def _count(self, robots: Sequence[int]) -> None:
        """Count the notes of the last run of these robots."""
        for i in robots:
            if (situation := self._situations[i]) is not None:
                self.tally.add(situation.all_notes)

    def _order(self, i: int) -> int:
        situation = self._situations[i]
        return 0 if situation is None else -len(situation.error)

    def _seeds(self, seed: Any) -> list[Any]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, str) or not isinstance(seed, Sequence | np.ndarray):
            first = whole("seed", seed, 0)
            return list(range(first, first + self.num_envs))
        if len(seed) != self.num_envs:
            raise ValueError(f"{self.num_envs} robots need as many seeds, got {len(seed)}")
        return list(seed)
