"""A law without design variables on random robots: motors alone, every run one of the law's own.

Each seed is another robot (the large one if even, the IRB1400 if odd), individual of its
production line, pose, speed and noise. A cut whose first run reaches a limit of the drives is drawn
again: there no correction moves a motor. The law was made on `DEVELOPMENT`, and on a few of 501 to
540 once friction was identified. `SEEN` have judged it before; those that judge count up from 300.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws.knob_free import KnobFree
from armside.ilc.learning import learn
from armside.ilc.measures import norms
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot.run import LoadedReference
from armside.sim.robot.spread import Drawn
from armside.sim.robot.virtual_robot import LOG_PERIOD

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_most
from ._random_cuts import random_cut

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


def run(seed: int, _: Tally) -> Iterator[Row]:
    yield cells(seed, learned(seed))


def cells(seed: int, one: Found) -> Row:
    """Row of one robot."""
    left = one.together
    return {
        "seed": seed,
        "robot": str(one.cut.robot),
        "speed [mm/s]": 1e3 * one.cut.speed,
        "runs to 10 %, motors together": runs_until(left),
        "worst motor (9.5)": runs_until(one.worst),
        "largest of any run": float(left[1:].max()),
        "k = 5": float(left[MEDIAN]),
        "last run": float(left[-1]),
        "_worst": float(one.worst[1:].max()),
    }


def checks(rows: Rows) -> Iterator[Check]:
    for words, reached, highest in (
        ("motors together", "runs to 10 %, motors together", "largest of any run"),
        ("worst motor, (9.5)", "worst motor (9.5)", "_worst"),
    ):
        runs, largest = rows[reached], rows[highest]
        statement = f"{words}: runs to {LEARNED:.0%} of k = 0"
        yield at_most(f"{statement}, median", float(np.median(runs)), MEDIAN, "g")
        yield at_most(f"{statement}, worst", float(runs.max()), WORST, "g")
        no_worse = f"{words}: no run worse than run 0; the highest is {largest.max():.3f} of it"
        yield all_hold(no_worse, largest <= 1.0)


CLAIM = Claim(
    title="A law without design variables on random robots: 2-norm of the motors over k = 0",
    seeds=100,
    run=run,
    checks=checks,
)
