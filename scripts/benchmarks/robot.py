"""Benchmarks of the virtual robot: overhead over bare physics, the default experiment, scaling."""

import time
from collections.abc import Sequence
from statistics import median

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.laser.experiment import prepare
from armside.sim.laser.results import run as run_cut
from armside.sim.laser.specification import Cut

from ..jobs.workers import Workers
from .timing import Row, interleaved

N_EXPERIMENTS = 12


def robot() -> Sequence[Row]:
    """One run against a bare rollout of the same steps; then the default experiment."""
    experiment = prepare(Cut())
    loaded = experiment.loaded
    correction = np.zeros_like(loaded.reference)
    controls = loaded.controls_with(correction, None)[0][None]
    state, data = loaded.initial_state[None], [mujoco.MjData(loaded.model.mj)]
    rng = np.random.default_rng(0)

    def bare() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([loaded.model.mj], data, state, controls)

    run, rollout = interleaved([lambda: loaded.run(correction, rng), bare])
    (whole,) = interleaved([lambda: run_cut(Cut())], repeats=5)
    return [
        Row("VirtualRobot run", run, "bare mujoco.rollout", rollout),
        Row("default experiment: six runs, all included", whole),
    ]


def scaling() -> Sequence[Row]:
    """Twelve independent experiments on two worker processes, which are up, and on one."""
    with Workers(1) as one, Workers(2) as two:
        for workers in (one, two):
            workers.map(_experiment, range(2 * workers.count))
        rounds = [(_seconds(two), _seconds(one)) for _ in range(5)]
    times = [median(column) for column in zip(*rounds, strict=True)]
    return [Row(f"{N_EXPERIMENTS} experiments, two workers", times[0], "one worker", times[1])]


def _experiment(seed: int) -> float:
    return run_cut(Cut(), seed=seed)["iterations"][-1]["arm_rms"]


def _seconds(workers: Workers) -> float:
    start = time.perf_counter()
    workers.map(_experiment, range(N_EXPERIMENTS))
    return time.perf_counter() - start
