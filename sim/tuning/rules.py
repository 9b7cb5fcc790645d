"""The rules of an episode, shared by the single and the vector env: spaces, draws, steps, rewards.

Reward of a step: log(RMS before / RMS after) of the tool's circle (9.6) as the configured sensor
sees it, clipped to [-5, 5]; -5 for a run that diverged; 0 where the sensor has no measure.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from ..cell import CELLS, Cell
from ..model import RobotModel, load_model
from . import observation, task
from .design import VARIABLES, Design, Motors, design_of
from .sensor import Sees, Sensor
from .situation import Situation, advance, begin
from .task import TEST_SEEDS, Task

WORST_REWARD = -5.0
"""Of a run that diverged; also the bound of every other."""


@dataclass(frozen=True)
class Rules:
    """What stays the same over all episodes. Safe to use from several threads."""

    robot: str = "large"
    motors: str = "shared"
    reward: str = "tracker"
    iterations: int = 5
    """Learning iterations of an episode: the budget of the thesis."""
    sealed: bool = False
    """Episodes are those of TEST_SEEDS, which are refused otherwise."""

    def __post_init__(self) -> None:
        _one_of("robot", self.robot, CELLS)
        _one_of("motors", self.motors, [m.value for m in Motors])
        _one_of("reward", self.reward, [s.value for s in Sees])
        if not (isinstance(self.iterations, int) and 1 <= self.iterations <= 10):
            raise ValueError(f"iterations must be in 1 .. 10, got {self.iterations!r}")
        if not isinstance(self.sealed, bool):
            raise ValueError(f"sealed must be True or False, got {self.sealed!r}")
        object.__setattr__(self, "_nominal", load_model(self.cell.xml))
        object.__setattr__(self, "_sensor", Sees(self.reward).sensor(self.robot))

    @property
    def cell(self) -> Cell:
        """The robot's cell."""
        return CELLS[self.robot]

    @property
    def nominal(self) -> RobotModel:
        """The robot as its controller knows it."""
        return self._nominal  # type: ignore[attr-defined]

    @property
    def sensor(self) -> Sensor:
        """What the reward is computed from."""
        return self._sensor  # type: ignore[attr-defined]

    @property
    def action_space(self) -> Box:
        """See `sim.tuning.design`."""
        return Box(-1.0, 1.0, (len(VARIABLES) * Motors(self.motors).count,), np.float32)

    @property
    def observation_space(self) -> Box:
        """See `sim.tuning.observation`."""
        return Box(-1.0, 1.0, (observation.SIZE,), np.float32)

    def check_seed(self, seed: int | None) -> None:
        """Raise ValueError where a seed is sealed, or no sealed one where it must be."""
        if self.sealed and (seed is None or seed not in TEST_SEEDS):
            raise ValueError(f"a sealed env is reset with a seed of {TEST_SEEDS}, got {seed}")
        if not self.sealed and seed is not None and seed in TEST_SEEDS:
            raise ValueError(
                f"seed {seed} belongs to the sealed test seeds {TEST_SEEDS}; "
                "only an env made with sealed=True takes them"
            )

    def draw(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Task:
        """Draw a task. See `sim.tuning.task.draw`."""
        return task.draw(self.robot, rng, options)

    def begin(self, drawn: Task) -> Situation:
        """Build the experiment of a task and run it without learning."""
        return begin(
            task.experiment(self.cell, self.nominal, drawn, Sees(self.reward).imu), self.sensor
        )

    def design(self, action: ArrayLike) -> Design:
        """The design of an action. Raises ValueError as `design_of` does."""
        return design_of(action, Motors(self.motors))

    def advance(self, situation: Situation, design: Design) -> Situation:
        """One iteration of learning."""
        return advance(situation, design)

    def score(self, before: Situation, after: Situation) -> float:
        """The reward of a step."""
        if after.diverged:
            return WORST_REWARD
        first, second = before.seen.rms, after.seen.rms
        if not (np.isfinite(first) and np.isfinite(second) and first > 0.0 and second > 0.0):
            return 0.0
        return float(np.clip(np.log(first / second), WORST_REWARD, -WORST_REWARD))

    def truncated(self, situation: Situation) -> bool:
        """The budget of iterations is used up."""
        return situation.k >= self.iterations and not situation.diverged

    def observe(self, situation: Situation) -> np.ndarray:
        """See `sim.tuning.observation`."""
        return observation.observation(situation)

    def info(self, situation: Situation, design: Design | None, reward: float) -> dict[str, Any]:
        """Physical values and truth: what a policy must not see and a person wants to.

        Keys: k, status (running, done or diverged), reward terms rms_seen and maxdev_seen [m] of
        the configured sensor and log_decrease; truth rms_true and maxdev_true [m];
        motor_error_two and motor_error_inf (6,) [rad] of the motor shaft; speed [m/s] reached;
        after a step gamma, delta [samples] and cutoff [Hz], (6,) each.
        """
        status = "done" if self.truncated(situation) else "running"
        return {
            "k": situation.k,
            "status": "diverged" if situation.diverged else status,
            "rms_seen": float(situation.seen.rms),
            "maxdev_seen": float(situation.seen.maxdev),
            "log_decrease": reward,
            "rms_true": float(situation.true.rms),
            "maxdev_true": float(situation.true.maxdev),
            "motor_error_two": situation.two_norm,
            "motor_error_inf": situation.inf_norm,
            "speed": float(situation.experiment.motion.reached_speed),
            **({} if design is None else design.arrays()),
        }


def _one_of(name: str, value: Any, allowed: Any) -> None:
    if value not in list(allowed):
        raise ValueError(f"Unknown {name} {value!r}. It can be: {', '.join(allowed)}")
