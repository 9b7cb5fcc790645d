"""The claim of `armside verify knob-free`: a law without design variables on random robots.

Each seed is another robot (the large one if even, the IRB1400 if odd), individual of its
production line, pose, speed and noise. A cut whose first run reaches a limit of the drives is drawn
again: there no correction moves a motor. The law was made on `DEVELOPMENT`, and on a few of 501 to
540 once friction was identified. `SEEN` have judged it before; those that judge count up from 300.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.knob_free import KnobFree
from armside.ilc.learning import learn
from armside.ilc.measures import norms
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.laser.experiment import prepare
from armside.sim.laser.random_cuts import random_cut
from armside.sim.laser.specification import Cut
from armside.sim.robot.run import LoadedReference
from armside.sim.robot.spread import Drawn
from armside.sim.robot.virtual_robot import LOG_PERIOD

DEVELOPMENT = (*range(1000, 1040), *range(501, 541))
"""Seeds that the law was made on."""
SEEN = tuple(range(300))
ROBOTS = ("large", "irb1400")
_MOST_DRAWS, _APART = 20, 1_000_000
LEARNED, MEDIAN, WORST = 0.10, 5, 10
"""Fraction of k = 0, and runs after run 0 until it is reached."""


@dataclass(frozen=True)
class _Motors:
    """Plant whose output is the motors' angles, without the instruments at the tool."""

    loaded: LoadedReference
    rng: np.random.Generator

    def run(self, correction: Array, /) -> Array:
        return self.loaded.run(correction, self.rng).motor_angle


@dataclass(frozen=True, eq=False)
class Found:
    """One robot: (K + 1,) norms of the motors' errors over those of k = 0."""

    cut: Cut
    together: Array
    """2-norm over all motors and samples, motor side."""
    worst: Array
    """2-norm of the worst motor, normalised as (9.5)."""


def case(seed: int) -> tuple[Cut, LoadedReference]:
    """A circle by a robot individual at a random pose and speed, within the limits of the drives.

    Raises RuntimeError where none is found.
    """
    for draw in range(_MOST_DRAWS):
        cut = random_cut(ROBOTS[seed % len(ROBOTS)], seed + _APART * draw)
        cut = replace(cut, individual=Drawn(seed))
        loaded = prepare(cut, seed=seed).loaded
        if not loaded.run(None, np.random.default_rng(seed)).limits_hit:
            return cut, loaded
    raise RuntimeError(f"no cut within the limits of the drives in {_MOST_DRAWS} draws")


def learned(seed: int) -> Found:
    """Learn a case: five updates, or as many as it takes, at most ten."""
    cut, loaded = case(seed)
    Q = ZeroPhaseButterworth(0.1 / LOG_PERIOD, LOG_PERIOD)
    law = KnobFree(Q=Q, reference=loaded.reference)
    plant, gear = _Motors(loaded, np.random.default_rng(seed)), loaded.model.drives.gear
    each, left, worst = list[Array](), np.empty(0), np.empty(0)
    for trial in learn(plant, law, loaded.reference, WORST):
        each.append(norms.two_norm(trial.error * gear))
        left = np.linalg.norm(each, axis=1) / np.linalg.norm(each[0])
        worst = norms.normalise(np.stack(each), each[0]).max(axis=1)
        if trial.k >= MEDIAN and max(runs_until(left), runs_until(worst)) < np.inf:
            break
    return Found(cut, left, worst)


def runs_until(left: Array) -> float:
    """Runs after run 0 until the fraction is reached; infinite if it is not."""
    below = np.flatnonzero(left <= LEARNED)
    return float(below[0]) if len(below) else np.inf


def knob_free(seeds: Iterable[int]) -> Table:
    """Motors alone: every run is one of the law's own."""
    numbers, found = list[int](), list[Found]()
    for seed in seeds:
        numbers.append(seed)
        found.append(learned(seed))
    columns = ("runs to 10 %, motors together", "worst motor (9.5)")
    left = ("largest of any run", "k = 5", "last run")
    return Table(
        "A law without design variables on random robots: 2-norm of the motors over k = 0",
        ("seed", "robot", "speed [mm/s]", *columns, *left),
        [_row(seed, one) for seed, one in zip(numbers, found, strict=True)],
        [*_verdicts(found)],
    )


def _row(seed: int, one: Found) -> tuple[object, ...]:
    counts = runs_until(one.together), runs_until(one.worst)
    left = one.together
    ends = float(left[1:].max()), float(left[MEDIAN]), float(left[-1])
    return seed, str(one.cut.robot), 1e3 * one.cut.speed, *counts, *ends


def _verdicts(found: list[Found]) -> Iterable[Check]:
    for name, words in (("together", "motors together"), ("worst", "worst motor, (9.5)")):
        left = [getattr(one, name) for one in found]
        runs = np.array([runs_until(each) for each in left])
        reached = f"{words}: runs to {LEARNED:.0%} of k = 0"
        yield _at_most(f"{reached}, median", float(np.median(runs)), MEDIAN)
        yield _at_most(f"{reached}, worst", float(runs.max()), WORST)
        highest = np.array([each[1:].max() for each in left])
        no_worse = f"{words}: no run worse than run 0; the highest is {highest.max():.3f} of it"
        yield all_hold(no_worse, highest <= 1.0)


def _at_most(statement: str, value: float, bar: float) -> Check:
    return Check("", f"{statement}: at most {bar:g} ({value:g})", "", value, high=bar)
