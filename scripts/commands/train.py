"""`armside train`: learn a policy for the tuning env with PPO, in minutes on two cores.

Needs Stable-Baselines3 (`pip install 'armside[learn]'`); what is learned is a small network that
`armside.scripts.studies.policy` runs with NumPy alone.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from armside.sim.records.run_folder import RUNS, RunFolder, check_writable
from armside.sim.records.summary import dumps, summary
from armside.sim.tuning.action import VARIABLES, Motors, action_of
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.task import TEST_SEEDS
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from ..shell.console import Report
from ..shell.errors import InputError, checking_input
from ..shell.interrupts import noticing
from ..shell.options import Common, options
from ..studies.tuned_design import load_design

GAMMA = 1.0
"""Discount: what counts is the error after the last iteration, however it was reached."""


@options
@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """What to learn, and for how long."""

    robot: Literal["large", "irb1400"] = "large"
    """Which robot."""
    motors: Literal["shared", "each"] = "shared"
    """One design for all motors, or one for each."""
    reward: Literal["tracker", "motor", "estimate"] = "tracker"
    """Sensor that the reward is computed from."""
    robots: int = 64
    """Robot cells that learn at the same time."""
    steps: int = 12800
    """Learning iterations of ILC over all cells; rounded up to whole episodes of every cell, 5
    iterations each."""
    start: Path | None = None
    """summary.json of armside tune: begin with the design found there [default: the middle of the
    ranges]."""

    def __post_init__(self) -> None:
        for name in ("robots", "steps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")
        Rules(robot=self.robot, motors=self.motors, reward=self.reward)
        first_action(self)


def first_action(cfg: TrainCfg) -> np.ndarray:
    """What the policy does before it has learned. Raises ValueError for a design it cannot do."""
    motors = Motors(cfg.motors)
    if cfg.start is None:
        return np.zeros(len(VARIABLES) * motors.count, np.float32)
    return action_of(load_design(cfg.start), motors)


def whole_batches(steps: int, batch: int) -> int:
    """The steps of as many whole batches as it takes: the network is updated after each."""
    return -(-steps // batch) * batch


def train(*, cfg: TrainCfg = TrainCfg(), common: Common = Common()) -> None:
    """Learn to choose the design of every ILC iteration with PPO. Sealed test seeds are refused.

    Writes policy.npz and summary.json, in which `steps` is how many were done. Raises InputError
    for a sealed seed or a folder that cannot be had, and where the extra [learn] is not installed.
    """
    report = Report(common)
    with checking_input():
        refuse_sealed(range(common.seed, common.seed + cfg.robots))
        check_writable(common.out or RUNS / "train")
        try:
            from ..studies import ppo
        except ImportError as error:
            raise InputError(
                f"training needs the package {error.name}: pip install 'armside[learn]'"
            ) from error
        env = IlcTuningVectorEnv(
            cfg.robots,
            robot=cfg.robot,
            motors=cfg.motors,
            reward=cfg.reward,
            autoreset_mode="SameStep",
        )
    steps = whole_batches(cfg.steps, env.rules.iterations * cfg.robots)
    with (
        noticing(lambda: "") as stop,
        closing(env),
        report.progress("learning", total=steps) as step,
    ):

        def done() -> None:
            step()
            stop.check()

        network, curve = ppo.learn(
            env,
            steps,
            start=first_action(cfg),
            seed=common.seed,
            discount=GAMMA,
            done=done,
        )
    outcome = summary("train", cfg, common, steps=steps, curve=curve)
    with RunFolder("train", seed=common.seed, out=common.out) as folder:
        network.save(folder / "policy.npz")
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    _print(report, curve, folder.path)
    report.summary(outcome)


def refuse_sealed(seeds: Sequence[int]) -> None:
    """Raise InputError where a seed is one that results are reported on."""
    for seed in seeds:
        if seed in TEST_SEEDS:
            raise InputError(f"seed {seed} belongs to the sealed test seeds {TEST_SEEDS}")


def _print(report: Report, curve: Sequence[dict[str, Any]], path: Path) -> None:
    shown = curve[:: max(1, len(curve) // 12)]
    report.table(
        "Return of an episode: log of the tool's RMS before learning over that after",
        ["steps", "mean", "diverged [%]"],
        [[row["steps"], row["mean_return"], 100.0 * row["diverged"]] for row in shown],
    )
    report.line(f"Results in {path}")
