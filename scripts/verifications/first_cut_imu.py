"""The claims of `armside verify first-cut-imu`: first cuts by a twin that no tracker has seen.

Tasks are drawn as those of `first_cut`; ten cuts, IMU and motors alone.
"""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from armside.arrays import Array
from armside.sim.evaluation.check import Check, Table, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.notes import Tally
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import commission
from armside.sim.twin.plan import MOST

from ..jobs.workers import Workers
from .first_cut import (
    N_TASKS,
    commissioning_cuts,
    first_runs,
    in_its_interval,
    in_the_interval,
    left_alone,
    together,
)
from .first_cut_tasks import JUDGED_BY_IMU, JUDGED_SEED, tasks

COLUMNS = (
    *("individual", "hidden hinges", "median left", "worst left", "worse than without"),
    *("inside the interval", "commissioning [s]"),
)


@dataclass(frozen=True, eq=False)
class Found:
    """Results of one individual."""

    number: int
    hinges: int
    left: Array
    """(30,)."""
    inside: Array
    """(n,) bool: the error was in the predicted interval, of the n tasks that were corrected."""
    seconds: float
    said: Tally = field(default_factory=Tally)
    """Notes of the runs of its tasks."""


def first_cut_imu(seeds: Iterable[int]) -> Table:
    """Six individuals, three with hidden hinges; thirty unseen tasks each."""
    numbers = [JUDGED_BY_IMU[seed % len(JUDGED_BY_IMU)] for seed in seeds]
    with Workers() as workers:
        found = workers.map(individual, numbers)
    title = "First cuts by a twin, commissioned by IMU and motors"
    said = together(one.said for one in found)
    rows = [_row(one) for one in found]
    return Table(title, COLUMNS, rows, verdicts(found), said.notes("runs"))


def individual(number: int, n_cuts: int = MOST, n_tasks: int = N_TASKS) -> Found:
    """Commission one individual by IMU and motors, and judge its first cuts."""
    robot, said = Drawn(number), Tally()
    cuts = commissioning_cuts(robot, n_cuts, ImuCfg())
    started = time.perf_counter()
    twin = commission(cuts, measure="imu").twin
    seconds = time.perf_counter() - started
    chosen = [cut for _, cut in tasks(n_tasks, JUDGED_SEED + number)]
    errors, corrections, _ = first_runs(twin, robot, chosen, said)
    return Found(
        number=number,
        hinges=len(robot.of(twin.design.nominal or twin.design.model).hidden),
        left=errors / [left_alone(cut, robot, said) for cut in chosen],
        inside=in_its_interval(errors, corrections),
        seconds=seconds,
        said=said,
    )


def _row(found: Found) -> tuple[object, ...]:
    left = found.left
    return (
        *(found.number, found.hinges, float(np.median(left)), float(left.max())),
        *(int((left > 1.0).sum()), float(found.inside.mean()), found.seconds),
    )


def verdicts(found: Sequence[Found]) -> list[Check]:
    """Verdicts on all individuals together."""
    inside = np.concatenate([one.inside for one in found])
    left = np.concatenate([one.left for one in found])
    return [
        Check("", "median left", "", float(np.median(left)), high=0.10),
        Check("", "worst left", "", float(left.max()), high=0.25),
        all_hold("no first cut is worse than without correction", left <= 1.0),
        in_the_interval("", inside),
    ]
