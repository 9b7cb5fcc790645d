"""A cut by a virtual robot as a task of the workbench: motor angles are learned."""

from collections.abc import Mapping

import numpy as np

from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import Model
from armside.ilc.workbench.task import Task

from ..evaluation.tool_error import tool_error
from ..robot.virtual_robot import LOG_PERIOD
from .design import default_design
from .experiment import Pass, prepare
from .loop import generators
from .specification import Cut

SERVO = System(np.array([0.0] * 5 + [0.5083]), np.array([1.0, -0.4884]), LOG_PERIOD)
"""T_u of each motor as identified on the large robot. Thesis (9.12)."""


def learning_task(cut: Cut, *, seed: int = 0, name: str = "", model: Model | None = None) -> Task:
    """Task of a cut. Beside the motors' error: arm_rms [m] by the tracker.

    model: T_u of every motor; the servo of thesis (9.12) on the large robot if None.

    Raises ValueError for a cut that cannot be made.
    """
    experiment = prepare(cut, seed=seed)
    motion, design = experiment.motion, default_design(cut.cell)
    if model is None and cut.robot == "large":
        model = SERVO

    def measures(run: Pass) -> Mapping[str, float]:
        return {"arm_rms": tool_error(motion, run.tracker.time, run.tracker.position).rms}

    return Task(
        name=name or str(cut.robot),
        reference=experiment.loaded.reference,
        sample_time=LOG_PERIOD,
        start=lambda repetition: prepare(cut, seed=seed, repetition=repetition).plant,
        output_of=lambda run: run.recording.motor_angle,
        measures_of=measures,
        generators_of=generators,
        model=model,
        place=motion.arc_length,
        cutoff=design.cutoff[0],
        design=(design.gamma[0], design.delta[0]),
    )
