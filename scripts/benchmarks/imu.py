"""Benchmarks of the IMU experiment: the robot against bare physics, and the whole of it."""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.imu import ImuExperiment, prepare
from armside.sim.robot.flexibility import Flexibility
from armside.sim.robot.virtual_robot import Job

from ..commands import imu as command
from ..shell.options import Common
from .timing import Row, interleaved


def imu() -> Sequence[Row]:
    """The 10 s simultaneous motion: one run of each form, and everything with its figures."""
    rows: list[Row] = []
    for form in reversed(Flexibility):
        job = prepare(ImuExperiment(flexibility=form))[0].job
        run, bare = interleaved([run_of(job), bare_rollout_of(job)], repeats=5)
        seconds = float(len(job.powered) * job.model.timestep)
        name = f"{form.value}: one run, {seconds / run:.0f} times real time"
        rows.append(Row(name, run, "bare mujoco.rollout", bare))
    with tempfile.TemporaryDirectory() as folder:
        (whole,) = interleaved([_whole(Path(folder))], repeats=5)
    return [*rows, Row("simultaneous experiment: planned, run, processed, drawn", whole)]


def run_of(job: Job) -> Callable[[], None]:
    """One run of a job, noise and recording included."""
    rng = np.random.default_rng(0)

    def run() -> None:
        job.run(rng=rng)

    return run


def bare_rollout_of(job: Job) -> Callable[[], None]:
    """The same steps and nothing else."""
    controls = job.controls_with(np.zeros_like(job.reference), None)[0][None]
    state, data = job.initial_state[None], [mujoco.MjData(job.model.mj)]

    def roll_out() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([job.model.mj], data, state, controls)

    return roll_out


def _whole(folder: Path) -> Callable[[], None]:
    count = iter(range(1_000_000))

    def experiment() -> None:
        command.imu(common=Common(out=folder / str(next(count)), quiet=True))

    return experiment
