"""Independent experiments on two processes, which are up, and on one."""

import time
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import get_context
from statistics import median

from tests.claims._learned import run

from armside.sim.laser.specification import Cut

from ._timing import Row

N_EXPERIMENTS = 12


def measured() -> Sequence[Row]:
    """Twelve experiments in each round."""
    fresh = get_context("forkserver")
    with ProcessPoolExecutor(1, fresh) as one, ProcessPoolExecutor(2, fresh) as two:
        for pool, count in ((one, 2), (two, 4)):
            list(pool.map(experiment, range(count)))
        rounds = [(_seconds(two), _seconds(one)) for _ in range(5)]
    times = [median(column) for column in zip(*rounds, strict=True)]
    return [Row(f"{N_EXPERIMENTS} experiments, two workers", times[0], "one worker", times[1])]


def experiment(seed: int) -> float:
    """Tool RMS that the default cut ends with [m]."""
    return run(Cut(), seed=seed)["iterations"][-1]["arm_rms"]


def _seconds(pool: Executor) -> float:
    start = time.perf_counter()
    list(pool.map(experiment, range(N_EXPERIMENTS)))
    return time.perf_counter() - start
