"""Whole episodes of the tuning env by a policy or a design, against ground truth."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.sim.laser.design import Design
from armside.sim.notes import Note
from armside.sim.tuning.action import Motors, action_of
from armside.sim.tuning.rules import Decision, Rules

Policy = Callable[[np.ndarray], np.ndarray]
"""From an observation to an action, as the spaces of `Rules` have them."""


@dataclass(frozen=True)
class Episode:
    """Outcome of one episode of K iterations, fewer where learning diverged."""

    rms_true: Array
    rms_measured: Array
    """(K + 1,) [m], of the tool after each run, and by the configured sensor."""
    decisions: Sequence[Decision]
    diverged: bool
    notes: Sequence[Sequence[Note]]
    """Limits that changed each run."""

    @property
    def ratio(self) -> float:
        """RMS of the tool after the last run over that before learning."""
        return float(self.rms_true[-1] / self.rms_true[0])


def run_episode(rules: Rules, seed: int, policy: Policy) -> Episode:
    """The episode of `reset(seed=seed)`, with the policy's actions. Raises as the env."""
    rules.check_seed(seed)
    runs, decisions = [rules.begin(rules.draw(np.random.default_rng(seed)))], list[Decision]()
    while not (runs[-1].diverged or rules.truncated(runs[-1])):
        decisions.append(rules.decision(policy(rules.observe(runs[-1]))))
        runs.append(rules.advance(runs[-1], decisions[-1]))
    true, measured = (np.array([getattr(r, by).rms for r in runs]) for by in ("true", "measured"))
    notes = [run.all_notes for run in runs]
    return Episode(true, measured, decisions, runs[-1].diverged, notes)


def evaluate(
    rules: Rules, seeds: Sequence[int], policy: Policy, *, threads: int = 1
) -> Iterator[Episode]:
    """The episodes of these seeds, in their order."""
    with ThreadPoolExecutor(threads) as pool:
        yield from pool.map(lambda seed: run_episode(rules, seed, policy), seeds)


def always(design: Design, motors: Motors) -> Policy:
    """The policy that takes the same design in each iteration. Raises ValueError as `action_of`."""
    action = action_of(design, motors)
    return lambda observed: action
