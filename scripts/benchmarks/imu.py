"""Benchmarks of the IMU experiment: the robot against bare physics, and the whole of it."""

import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from itertools import count
from pathlib import Path

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.imu import ImuExperiment, prepare
from armside.sim.imu import run as run_experiment
from armside.sim.records.run_folder import RunFolder
from armside.sim.robot.flexibility import Flexibility
from armside.sim.robot.run import LoadedReference

from ..figures.imu_results import write_runs
from .timing import Row, interleaved


def imu() -> Sequence[Row]:
    """The 10 s simultaneous motion: one run of each form, and everything with its figures."""
    rows: list[Row] = []
    for form in reversed(Flexibility):
        loaded, rng = prepare(ImuExperiment(flexibility=form))[0].loaded, np.random.default_rng(0)
        run, bare = interleaved([partial(loaded.run, rng=rng), _bare_rollout(loaded)], repeats=5)
        seconds = float(len(loaded.powered) * loaded.model.timestep)
        name = f"{form.value}: one run, {seconds / run:.0f} times real time"
        rows.append(Row(name, run, "bare mujoco.rollout", bare))
    with tempfile.TemporaryDirectory() as folder:
        outs = (Path(folder) / str(i) for i in count())
        (whole,) = interleaved([lambda: _whole(next(outs))], 5)
    return [*rows, Row("simultaneous experiment: planned, run, processed, drawn", whole)]


def _whole(out: Path) -> None:
    """The experiment with its files."""
    with RunFolder("imu", seed=0, out=out) as folder:
        write_runs(run_experiment(ImuExperiment()), folder, {"seed": 0})


def _bare_rollout(loaded: LoadedReference) -> Callable[[], None]:
    """The same steps and nothing else."""
    controls = loaded.controls_with(np.zeros_like(loaded.reference), None)[0][None]
    state, data = loaded.initial_state[None], [mujoco.MjData(loaded.model.mj)]

    def roll_out() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([loaded.model.mj], data, state, controls)

    return roll_out
