"""Benchmarks of the IMU experiment: the robot against bare physics, and the whole of it."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.robot.run import LoadedReference

from ..commands import imu as command
from ..shell.options import Common
from .timing import Row, interleaved


def imu() -> Sequence[Row]:
    """The 10 s simultaneous motion: one run of each form, and everything with its figures."""
    rows: list[Row] = []
    for form in ("full", "gears", "rigid"):
        cfg = replace(command.ImuExperimentCfg(), flexibility=form)
        loaded = command.prepare(cfg)[0].loaded
        run, bare = interleaved([run_of(loaded), bare_rollout_of(loaded)], repeats=5)
        seconds = float(len(loaded.powered) * loaded.model.timestep)
        name = f"{form}: one run, {seconds / run:.0f} times real time"
        rows.append(Row(name, run, "bare mujoco.rollout", bare))
    with tempfile.TemporaryDirectory() as folder:
        (whole,) = interleaved([_whole(Path(folder))], repeats=5)
    return [*rows, Row("simultaneous experiment: planned, run, processed, drawn", whole)]


def run_of(loaded: LoadedReference) -> Callable[[], None]:
    """One run of a loaded reference, noise and recording included."""
    rng = np.random.default_rng(0)

    def run() -> None:
        loaded.run(rng=rng)

    return run


def bare_rollout_of(loaded: LoadedReference) -> Callable[[], None]:
    """The same steps and nothing else."""
    controls = loaded.controls_with(np.zeros_like(loaded.reference), None)[0][None]
    state, data = loaded.initial_state[None], [mujoco.MjData(loaded.model.mj)]

    def roll_out() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([loaded.model.mj], data, state, controls)

    return roll_out


def _whole(folder: Path) -> Callable[[], None]:
    count = iter(range(1_000_000))

    def experiment() -> None:
        command.imu(common=Common(out=folder / str(next(count)), quiet=True))

    return experiment
