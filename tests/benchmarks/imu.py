"""Benchmarks of the IMU experiment: the robot against bare physics, and the whole of it."""

import tempfile
from collections.abc import Sequence
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np

from armside.scripts.figures.imu_results import write_runs
from armside.sim.imu import ImuExperiment, prepare
from armside.sim.imu import run_imu as run_experiment
from armside.sim.records.run_folder import RunFolder
from armside.sim.robot.flexibility import Flexibility

from ._timing import Row, bare_rollout, interleaved


def measured() -> Sequence[Row]:
    """The 10 s simultaneous motion: one run of each form, and everything with its figures."""
    rows: list[Row] = []
    for form in reversed(Flexibility):
        loaded, rng = prepare(ImuExperiment(flexibility=form))[0].loaded, np.random.default_rng(0)
        run, bare = interleaved([partial(loaded.run, rng=rng), bare_rollout(loaded)], repeats=5)
        seconds = float(len(loaded.powered) * loaded.model.timestep)
        name = f"{form.value}: one run, {seconds / run:.0f} times real time"
        rows.append(Row(name, run, "bare mujoco.rollout", bare))
    with tempfile.TemporaryDirectory() as parent:
        outs = (Path(parent) / str(i) for i in count())

        def whole() -> None:
            with RunFolder("imu", seed=0, out=next(outs)) as folder:
                write_runs(run_experiment(ImuExperiment()), folder, {"seed": 0})

        (seconds,) = interleaved([whole], 5)
    return [*rows, Row("simultaneous experiment: planned, run, processed, drawn", seconds)]
