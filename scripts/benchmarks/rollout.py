"""The physics alone, for comparison."""

from collections.abc import Callable

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.sim.robot.run import LoadedReference


def bare_rollout(loaded: LoadedReference) -> Callable[[], None]:
    """A function of the steps of a run and nothing else."""
    controls = loaded.controls_with(np.zeros_like(loaded.reference), None)[0][None]
    state, data = loaded.initial_state[None], [mujoco.MjData(loaded.model.mj)]

    def roll_out() -> None:
        with Rollout(nthread=0) as rollout:
            rollout.rollout([loaded.model.mj], data, state, controls)

    return roll_out
