"""`armside train`: learn a policy for the tuning env with PPO, in minutes on two cores.

Needs Stable-Baselines3 (`pip install 'armside[learn]'`); what is learned is a small network that
`armside.sim.tuning.policies` runs with NumPy alone.
"""

from contextlib import closing
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.sim.records.run_folder import RUNS, check_writable
from armside.sim.records.summary import summary
from armside.sim.tuning.action import Motors
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from ..shell.console import Report, run_folder
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import checking_input, needs
from ..shell.interrupts import noticing
from ..shell.options import Common, Count, FileToRead, options, seed_range
from ..studies.options import Radius, Shapes, contour_options
from ..studies.study import first_action, whole_batches

DISCOUNT = 1.0
"""None: only the error after the last iteration counts, however it was reached."""

OF_A_ROBOT, OF_A_STEP = Effort(1.0, 10e6), Effort(0.1)


@options
@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """Task of the policy, and length of its training."""

    robot: str = "large"
    """Robot: large, irb1400, or a robot file (.toml)."""
    motors: Literal["shared", "each"] = "shared"
    """One design for all motors, or one for each."""
    action: Literal["design", "correction"] = "design"
    """What the policy chooses: the design of an iteration, or the next correction itself, made of
    functions for each axis."""
    basis: Literal["b-splines", "harmonics"] = "b-splines"
    """Functions of corrections."""
    functions: int = 12
    """Functions of each axis."""
    reward: Literal["tracker", "motor", "estimate"] = "tracker"
    """Sensor that the reward is computed from."""
    shape: Shapes = ("circle",)
    """Shapes of the contours; of several, each episode draws one."""
    radius: Radius = ()
    """Radius of a circle, half the size of another shape, or the range that each episode draws from
    [mm] [default: 2 to 12; slot 15, square and hexagon 10]."""
    robots: Count = 64
    """Robot cells that learn at the same time."""
    steps: Count = 12800
    """Learning iterations of ILC over all cells; rounded up to whole episodes of every cell, 5
    iterations each."""
    start: Annotated[FileToRead, Parameter(name="--from")] = None
    """summary.json of armside tune: begin with the design found there [default: the middle of the
    ranges]."""

    def __post_init__(self) -> None:
        if self.action == "correction" and self.start is not None:
            raise ValueError("--from names a design, and actions are corrections: leave it out")
        self.first  # noqa: B018 - raises ValueError

    @property
    def rules(self) -> Rules:
        """Rules of the episodes."""
        return Rules(**self.task)

    @property
    def task(self) -> dict[str, Any]:
        """Options of the env."""
        of_contour = contour_options(self.shape, self.radius)
        of_action = {"action": self.action, "basis": self.basis, "functions": self.functions}
        own = {"robot": self.robot, "motors": self.motors, "reward": self.reward}
        own |= {"version": 1}  # whose reward looks past the last update
        return own | of_action | of_contour

    @property
    def first(self) -> np.ndarray:
        """Action that the policy begins with: a design, or no correction."""
        rules = self.rules
        if self.action == "correction":
            return np.zeros(rules.action_space.shape, np.float32)
        return first_action(self.start, Motors(self.motors), rules.n_axes)


def train(*, cfg: TrainCfg = TrainCfg(), common: Common = Common()) -> None:
    """Learn to choose the design of every ILC iteration, or the correction itself, with PPO.

    Sealed test seeds are refused.

    Writes policy.npz and summary.json, in which `steps` is how many were done.

    Raises InputError for a sealed seed or a folder that cannot be had, and where the extra [learn]
    is not installed.
    """
    report = Report(common)
    with checking_input():
        rules = cfg.rules
        refuse_absurd(f"{cfg.robots} robots", OF_A_ROBOT * cfg.robots)
        refuse_absurd(f"{cfg.steps} steps", OF_A_STEP * cfg.steps)
        for seed in seed_range(common.seed, cfg.robots):
            rules.check_seed(seed)
        check_writable(common.out or RUNS / "train")
        with needs("learn", "armside train", "Stable-Baselines3"):
            from ..studies import ppo
        env = IlcTuningVectorEnv(cfg.robots, **cfg.task, autoreset_mode="SameStep")
    steps = whole_batches(cfg.steps, env.rules.iterations * cfg.robots)
    learning = report.progress("learning", total=steps)
    with noticing(lambda: "") as stop, closing(env), learning as step:

        def done() -> None:
            step()
            stop.check()

        network, curve = ppo.learn(
            env, steps, start=cfg.first, seed=common.seed, discount=DISCOUNT, done=done
        )
    outcome = summary("train", cfg, common, steps=steps, curve=curve, notes=env.notes)
    with run_folder(outcome, common) as folder:
        network.save(folder / "policy.npz")
    report.notes(env.notes)
    shown = curve[:: max(1, len(curve) // 12)]
    report.table(
        "Return of an episode: log of the tool's RMS before learning over that after",
        ["steps", "mean", "diverged [%]"],
        [[row["steps"], row["mean_return"], 100.0 * row["diverged"]] for row in shown],
    )
    report.results(outcome, folder.path)
