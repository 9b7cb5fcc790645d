"""Benchmark of the tuning env: what its steps cost beyond the physics they run."""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.arrays import Array
from armside.assets import LARGE_ROBOT_XML
from armside.sim.laser.design import THESIS
from armside.sim.robot.run import cores
from armside.sim.tuning.action import Motors, action_of
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.situation import restarted
from armside.sim.tuning.vector_env import IlcTuningVectorEnv

from ._timing import Row, interleaved

ROBOTS = 64
FILES = ("two_link.toml", "ur5e_like.toml", "panda_like.toml")
"""Robot files that are measured: two, six and seven axes."""
OF_FILES = 16
OPTIONS = {"speed": 0.040}
"""Records of one length: the fastest for a common rollout."""


def measured() -> Sequence[Row]:
    """Steps of large robots and of robots of files, and an episode, against bare rollouts."""
    cells = IlcTuningVectorEnv(ROBOTS, autoreset_mode="Disabled", iterations=10)
    action = np.tile(action_of(THESIS, Motors.SHARED), (ROBOTS, 1))
    cells.reset(seed=0, options=OPTIONS)
    bare = _bare(cells)

    def episode() -> None:
        cells.reset(seed=0, options=OPTIONS)
        for _ in range(5):
            cells.step(action)

    def bare_episode() -> None:
        for _ in range(6):
            bare()

    ours, theirs = interleaved([_stepping(cells, action), bare], repeats=8)
    whole, bare_whole = interleaved([episode, bare_episode], repeats=3)
    cells.close()
    peer = f"bare mujoco.rollout, {cores()} threads"
    looking, plain = interleaved([_last_step(1), _last_step(0)], repeats=5)
    return [
        Row(f"step of {ROBOTS} robots", ours, peer, theirs),
        Row("episode: reset with planning, five steps", whole, peer, bare_whole),
        Row(f"last step of {OF_FILES} robots, which looks ahead", looking, "of version 0", plain),
        *(_step_of_file(file, peer) for file in FILES),
    ]


def _last_step(version: int) -> Callable[[], None]:
    """The last step of the same episodes over and over."""
    rules = Rules(version=version, iterations=1)
    options = OPTIONS | {"pose": "p1", "radius": 0.005, "payload": 50.0}
    each = [rules.begin(rules.draw(np.random.default_rng(i), options)) for i in range(OF_FILES)]

    def step() -> None:
        for before in each:
            after = rules.advance(restarted(before), THESIS)
            rules.step(before, after, THESIS)

    return step


def _step_of_file(name: str, peer: str) -> Row:
    """A step of the robots of a file, at the first pose and speed that they draw."""
    file = LARGE_ROBOT_XML.with_name(name)
    cells = IlcTuningVectorEnv(OF_FILES, robot=file, autoreset_mode="Disabled", iterations=10)
    cells.reset(seed=0, options=OPTIONS)
    action = np.tile(action_of(THESIS, Motors.SHARED), (OF_FILES, 1))
    ours, theirs = interleaved([_stepping(cells, action), _bare(cells)], repeats=8)
    cells.close()
    return Row(f"step of {OF_FILES} robots of {file.stem}", ours, peer, theirs)


def _stepping(cells: IlcTuningVectorEnv, action: Array) -> Callable[[], None]:
    """A step of all robots, which start again once their episodes are over."""

    def step() -> None:
        if cells.episodes_over.any():
            cells.reset(seed=0, options=OPTIONS)
        cells.step(action)

    return step


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
