"""First cuts by a twin that no tracker has seen: commissioned from ten cuts, by IMU and motors.

Six individuals, three with hidden hinges; tasks are drawn as those of `first-cut`.
"""

import time
from collections.abc import Iterator

import numpy as np

from armside.sim.evaluation.check import Check, all_hold
from armside.sim.instruments.imu import ImuCfg
from armside.sim.notes import Tally
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import MOST, commission

from ._engine import Claim, Row, Rows
from ._tasks import JUDGED_BY_IMU, JUDGED_SEED, tasks
from ._twins import (
    commissioning_cuts,
    first_runs,
    hidden_hinges,
    in_its_interval,
    in_the_interval,
    left_alone,
)
from .first_cut import N_TASKS


def run(seed: int, tally: Tally) -> Iterator[Row]:
    yield individual(JUDGED_BY_IMU[seed % len(JUDGED_BY_IMU)], tally)


def individual(number: int, tally: Tally, n_cuts: int = MOST, n_tasks: int = N_TASKS) -> Row:
    """Commission one individual by IMU and motors, and judge its first cuts."""
    robot = Drawn(number)
    cuts = commissioning_cuts(robot, n_cuts, ImuCfg())
    started = time.perf_counter()
    twin = commission(cuts, measure="imu").twin
    seconds = time.perf_counter() - started
    chosen = [cut for _, cut in tasks(n_tasks, JUDGED_SEED + number)]
    errors, corrections, _ = first_runs(twin, robot, chosen, tally)
    left = errors / [left_alone(cut, robot, tally) for cut in chosen]
    inside = in_its_interval(errors, corrections)
    return cells(number, hidden_hinges(twin, robot), left, inside, seconds)


def cells(number: int, hinges: int, left: np.ndarray, inside: np.ndarray, seconds: float) -> Row:
    """left: (n_tasks,). inside: (m,) bool, of the tasks that were corrected."""
    return {
        **{"individual": number, "hidden hinges": hinges},
        **{"median left": float(np.median(left)), "worst left": float(left.max())},
        "worse than without": int((left > 1.0).sum()),
        "inside the interval": float(inside.mean()),
        "commissioning [s]": seconds,
        **{"_left": left, "_inside": inside},
    }


def checks(rows: Rows) -> Iterator[Check]:
    left = rows.joined("_left")
    yield Check("", "median left", "", float(np.median(left)), high=0.10)
    yield Check("", "worst left", "", float(left.max()), high=0.25)
    yield all_hold("no first cut is worse than without correction", left <= 1.0)
    yield in_the_interval("", rows.joined("_inside"))


CLAIM = Claim(
    title="First cuts by a twin, commissioned by IMU and motors", seeds=6, run=run, checks=checks
)
