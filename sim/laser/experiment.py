"""One experiment: a cut by one robot individual under one tracker, before and after each run."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.ilc.learning import LoopState, Trial

from ..evaluation.tool_error import ToolError, tool_error
from ..motion.tool_motion import ToolMotion
from ..notes import Note
from ..robot.model import RobotModel
from ..robot.statics import Statics
from .plant import Pass, plan
from .rig import Rig, rig
from .specification import Cut


@dataclass(frozen=True, kw_only=True)
class Experiment(Rig):
    """Everything that is fixed before the first run."""

    cut: Cut
    motion: ToolMotion = field(repr=False)

    @property
    def setup(self) -> Cut:
        """Robot and its state."""
        return self.cut

    @property
    def programmed(self) -> Array:
        """(N, 3) [m], positions of the tool."""
        return self.motion.position

    @property
    def turn_rate(self) -> float:
        """[turns/s], of the contour at the programmed speed."""
        return self.motion.programmed_speed / self.motion.path.curve.length

    @property
    def motion_end(self) -> int:
        """First sample of the log at which the reference rests again."""
        motion = self.motion
        return int(np.searchsorted(motion.time, motion.rest_before + motion.timing.duration))


@dataclass(frozen=True, kw_only=True)
class Iteration:
    """One iteration: correction, run, and errors of motors and tool."""

    k: int
    correction: Array = field(repr=False)
    """u_k, (N, n) [rad], arm side."""
    error: Array = field(repr=False)
    """Error of the learned output: motor angles (N, n) [rad], arm side, or path of the tool (N, 6)
    [m], [rad]."""
    run: Pass = field(repr=False)
    motor_error: Array = field(repr=False)
    """(N, n) [rad] of the motor shaft, before the gear. Thesis 9.2.3."""
    tool: ToolError
    """From tracker samples; `tool_true` from the ground truth."""
    tool_true: ToolError
    diverged: bool
    notes: tuple[Note, ...] = ()
    """Notes of the learning loop."""
    state: LoopState | None = field(default=None, repr=False)
    """State of the loop after it; None for a run that was not made by one."""


def prepare(
    cut: Cut, *, seed: int = 0, repetition: int = 0, nominal: RobotModel | None = None
) -> Experiment:
    """Draw the robot individual, set up the tracker and load the motion.

    Args:
        seed: of the tracker's set-up, of all noise and, where the cut has no individual, of the
            robot's friction, in separate streams.
        repetition: of the same experiment: other noise, everything else alike.
        nominal: the cut's model, where it is loaded already; with the tool of its file.

    Raises:
        ValueError: the cut leaves the joint limits (where) or the reach (by how much), the robot
            cannot carry its payload, or the cut's model is that of another robot.
    """

    def planned(nominal: Statics) -> tuple[ToolMotion, Array]:
        pose = cut.tool_pose
        return plan(cut.cell, nominal, cut.path, pose.quaternion, cut.speed, cut.limits)

    motion, found = rig(cut, planned, seed=seed, repetition=repetition, nominal=nominal)
    return Experiment(**vars(found), cut=cut, motion=motion)


def evaluated(
    experiment: Experiment, trial: Trial[Any], run: Pass, notes: tuple[Note, ...] = ()
) -> Iteration:
    """A trial and its run, with errors of motors and tool."""
    motion = experiment.motion
    return Iteration(
        k=trial.k,
        correction=trial.correction,
        error=trial.error,
        run=run,
        motor_error=run.recording.error * experiment.loaded.model.drives.gear,
        tool=tool_error(motion, run.tracker.time, run.tracker.position),
        tool_true=true_tool_error(motion, run),
        diverged=trial.diverged,
        notes=notes,
        state=None if trial.first_size is None else trial.state,
    )


def true_tool_error(motion: ToolMotion, run: Pass) -> ToolError:
    """Tool error from the ground truth, at the rate of the tracker."""
    truth, seen = run.recording.truth, run.tracker.time
    every = slice(None, None, round(float((seen[1] - seen[0]) / (truth.time[1] - truth.time[0]))))
    return tool_error(motion, truth.time[every], truth.tool_position[every])
