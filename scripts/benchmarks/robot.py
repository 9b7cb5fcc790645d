"""Benchmarks of the virtual robot: overhead over bare physics, the default experiment, scaling."""

import time
from collections.abc import Sequence
from statistics import median

import numpy as np

from armside.sim.laser.experiment import prepare
from armside.sim.laser.results import run as run_cut
from armside.sim.laser.specification import Cut

from ..jobs.workers import Workers
from .rollout import bare_rollout
from .timing import Row, interleaved

N_EXPERIMENTS = 12


def robot() -> Sequence[Row]:
    """One run against a bare rollout of the same steps; then the default experiment."""
    loaded = prepare(Cut()).loaded
    correction, rng = np.zeros_like(loaded.reference), np.random.default_rng(0)
    run, rollout = interleaved([lambda: loaded.run(correction, rng), bare_rollout(loaded)])
    (whole,) = interleaved([lambda: run_cut(Cut())], repeats=5)
    return [
        Row("VirtualRobot run", run, "bare mujoco.rollout", rollout),
        Row("default experiment: six runs, all included", whole),
    ]


def scaling() -> Sequence[Row]:
    """Twelve independent experiments on two worker processes, which are up, and on one."""
    with Workers(1) as one, Workers(2) as two:
        for workers in (one, two):
            workers.map(experiment, range(2 * workers.count))
        rounds = [(_seconds(two), _seconds(one)) for _ in range(5)]
    times = [median(column) for column in zip(*rounds, strict=True)]
    return [Row(f"{N_EXPERIMENTS} experiments, two workers", times[0], "one worker", times[1])]


def experiment(seed: int) -> float:
    """Tool RMS that the default cut ends with [m]."""
    return run_cut(Cut(), seed=seed)["iterations"][-1]["arm_rms"]


def _seconds(workers: Workers) -> float:
    start = time.perf_counter()
    workers.map(experiment, range(N_EXPERIMENTS))
    return time.perf_counter() - start
