"""Benchmark of the tuning env: what its steps cost beyond the physics they run."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.cores import cores
from armside.sim.laser.design import THESIS
from armside.sim.tuning.action import Motors, action_of
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from .timing import Row, interleaved

ROBOTS = 64


def env() -> Sequence[Row]:
    """A step of 64 robots, and an episode of them, against bare rollouts of the same steps."""
    cells = IlcTuningVectorEnv(ROBOTS, autoreset_mode="Disabled", iterations=10)
    action = np.tile(action_of(THESIS, Motors.SHARED), (ROBOTS, 1))
    options = {"speed": 0.040}  # records of one length: the fastest for a common rollout
    cells.reset(seed=0, options=options)
    bare = _bare(cells)

    def step() -> None:
        if cells.episodes_over.any():
            cells.reset(seed=0, options=options)
        cells.step(action)

    def episode() -> None:
        cells.reset(seed=0, options=options)
        for _ in range(5):
            cells.step(action)

    def bare_episode() -> None:
        for _ in range(6):
            bare()

    ours, theirs = interleaved([step, bare], repeats=8)
    whole, bare_whole = interleaved([episode, bare_episode], repeats=3)
    cells.close()
    peer = f"bare mujoco.rollout, {cores()} threads"
    return [
        Row(f"step of {ROBOTS} robots", ours, peer, theirs),
        Row("episode: reset with planning, five steps", whole, peer, bare_whole),
    ]


def _bare(cells: IlcTuningVectorEnv) -> Callable[[], None]:
    references = [situation.experiment.loaded for situation in cells.situations]
    models = [loaded.model.mj for loaded in references]
    controls = np.stack([loaded.controls for loaded in references])
    initial = np.stack([loaded.initial_state for loaded in references])
    data = [mujoco.MjData(models[0]) for _ in range(cores())]

    def run() -> None:
        with Rollout(nthread=cores()) as rollout:
            rollout.rollout(models, data, initial, controls)

    return run
