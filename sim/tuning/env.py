"""`armside/IlcTuning-v0` and `-v1`: choose the design of each ILC iteration of one robot cell."""

import copy
from typing import Any

import gymnasium
import numpy as np

from .picture import PICTURES
from .rules import Rules, Step, show_compilation
from .situation import Situation


class IlcTuningEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One step is one ILC iteration: learn with the design of the action, run, observe.

    Action: float32 in [-1, 1], -1 is low, +1 is high. With one design for all motors it has shape
    (3,), in the order of the table; with one for each of n motors (3 n,), n of each variable.

    | variable | low | high | unit | scale |
    |---|---|---|---|---|
    | gamma | 0.1 | 1.5 | - | linear |
    | delta | 0 | 25 | samples of 4 ms | whole numbers |
    | cutoff | 1 | 30 | Hz | logarithmic |

    With action="correction" it is the next correction itself, for learning algorithms that stand
    beside laws: (n m,), m coefficients of axis 1, then of axis 2 and so on. Each multiplies one of
    m B-splines or sines over the record, which are zero at both ends, and five times the RMS of the
    axis's error before learning (`armside.sim.tuning.action`).

    Observation: (8 n + 2,) float32, in version 1 (8 n + 5,), signals of a robot cell with n axes
    after a run, without the tool's position. With six axes:

    | entries | feature | unit | low | high | scale |
    |---|---|---|---|---|---|
    | 0:6 | motor error, 2-norm over the record | rad | 1e-3 | 1e2 | log10 |
    | 6:12 | motor error, infinity-norm | rad | 1e-4 | 1e1 | log10 |
    | 12:18 | motor error, RMS in 0-3 Hz | rad | 1e-6 | 1e1 | log10 |
    | 18:24 | motor error, RMS in 3-8 Hz | rad | 1e-6 | 1e1 | log10 |
    | 24:30 | motor error, RMS in 8-16 Hz | rad | 1e-6 | 1e1 | log10 |
    | 30:36 | motor error, RMS in 16-125 Hz | rad | 1e-6 | 1e1 | log10 |
    | 36:42 | correction, 2-norm over the record | rad | 1e-3 | 1e2 | log10 |
    | 42:48 | joint position at the start, motors, arm side | rad | -6.2832 | 6.2832 | linear |
    | 48:49 | commanded speed | m/s | 0 | 0.1 | linear |
    | 49:50 | iteration k | - | 0 | 10 | linear |

    Errors and corrections are those of the motor shaft; with a twin, errors of the twin's motors.
    In version 1 the payload (0 to 120 kg, linear) follows.
    Where contours are drawn, the radius (0.001 to 0.1 m, log10) follows, and an entry for each of
    the shapes, +1 for the one that is cut and -1 for the others. Prismatic axes have m for rad.
    Where actions are corrections, last error and last correction follow, (n m,) each, fitted in the
    basis and scaled as actions are.
    Low becomes -1 and high +1; values outside are clipped, values that are not finite become +1.

    Reward: log(RMS before / RMS after) of the tool's contour as measured by the configured sensor,
    clipped to [-5, 5]; -5 for a run that diverged; 0 where the sensor has no measure. In version 1
    the last design of an episode is held up to update 20, by the model of the motors, and one more
    run has the correction predicted there: the last reward is that of the worse of the two runs,
    and -5 where the design's criterion is 1 or more.

    Info: `armside.sim.tuning.rules.Rules.info`. Tasks: `armside.sim.tuning.episode_task`.
    An episode is truncated after `iterations` steps and terminated by a run that diverges.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012 - of Gymnasium

    def __init__(
        self, *, render_mode: str | None = None, picture: str = "drawing", **options: Any
    ) -> None:
        """
        Args:
            render_mode: rgb_array or None.
            picture: drawing (contour and errors, no GL needed) or mujoco (the robot).
            options: fields of `armside.sim.tuning.rules.EnvCfg`.

        Raises ValueError for a value that does not exist; the message lists those that do.
        """
        show_compilation()
        self.rules = Rules(**options)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"Unknown render_mode {render_mode!r}. It can be: rgb_array")
        self.render_mode = render_mode
        if picture not in list(PICTURES):
            known = ", ".join(PICTURES)
            raise ValueError(f"Unknown picture {picture!r}. It can be: {known}")
        self.picture = picture
        self.action_space = self.rules.action_space
        self.observation_space = self.rules.observation_space
        self._history: list[Situation] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Draw a task, or take from `options` what they give, and run once without learning.

        options: any of `pose` (a name or a ToolPose), `speed` in [0.001, 0.1] m/s, `payload` (mass
        of the tool, [kg]), `individual` (a seed, a `Drawn` or an `Individual`), `shape` and
        `radius` [m].

        Returns:
            observation float32, and info of `armside.sim.tuning.rules`.

        Raises:
            ValueError: options that do not exist, out of reach (`UnreachableError`) or
                more than the robot can carry; a seed that is sealed, or that has to be. The
                env is then as if it had not been asked.
        """
        seed = self.rules.check_seed(seed)
        before = copy.deepcopy((self._np_random, self._np_random_seed))
        super().reset(seed=seed)
        try:
            situation = self.rules.begin(self.rules.draw(self.np_random, options))
        except BaseException:
            self._np_random, self._np_random_seed = before
            raise
        self._history = [situation]
        return self.rules.observe(situation), self.rules.info(situation)

    def step(self, action: np.ndarray) -> Step:
        """Learn once and run.

        Args:
            action: (3,) or (3 n,), or (n m,) where actions are corrections, in [-1, 1].

        Returns:
            observation float32, reward, diverged, budget used up, and info.

        Raises:
            ValueError: an action of the wrong shape, outside of its space or NaN; the episode goes
                on as if it had not been given.
            RuntimeError: before `reset`, or after the episode is over.
        """
        decision = self.rules.decision(action)
        if not self._history:
            raise RuntimeError("call reset before the first step")
        before = self._history[-1]
        if before.diverged or self.rules.truncated(before):
            raise RuntimeError("this episode is over: call reset before the next step")
        after = self.rules.advance(before, decision)
        self._history.append(after)
        return self.rules.step(before, after, decision)

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """(320, 640, 3) uint8 of the episode so far; None without a render mode.

        Raises:
            RuntimeError: before `reset`; `NoGraphicsError`, one of it, where
                picture="mujoco" finds no OpenGL.
        """
        if self.render_mode is None:
            return None
        if not self._history:
            raise RuntimeError("there is nothing to draw yet: call reset first")
        return PICTURES[self.picture](self._history, self.rules)
