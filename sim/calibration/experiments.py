"""Experiments of calibration: the nominal robot with its gear effects, without noise."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.ilc.laws import Heuristic
from armside.ilc.learning import learn
from armside.ilc.measures import norms as measures

from ..cell import LARGE_CELL
from ..cut.tool_motion import ToolMotion
from ..evaluation.check import Check
from ..evaluation.tool_error import ArmSide, arm_side
from ..laser.experiment import CircleTask
from ..laser.plant import plan
from ..robot.effects import Effect, with_effects
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD, Job, VirtualRobot
from . import targets
from .targets import POSES, RIPPLE_BAND, Result

_TRACKER_STRIDE = 2  # physics steps per tracker sample


@dataclass(frozen=True)
class _Plant:
    job: Job

    def run(self, correction: Array, /) -> Recording:
        return self.job.run(correction)


def learned(
    model: RobotModel,
    effects: frozenset[Effect],
    pose: str,
    *,
    speed: float = 0.040,
    cutoff: float = 10.0,
    delta: int = 3,
    iterations: int = 5,
) -> Result:
    """Run one experiment of the nominal robot; a result as `targets` reads it, of the true tool.

    speed: [m/s]. cutoff: [Hz].
    """
    task = CircleTask(pose=LARGE_CELL.poses[pose], speed=speed)
    motion, reference = plan(LARGE_CELL, model, task.path, task.pose.quaternion, speed)
    job = VirtualRobot(with_effects(model, effects, phi=reference[0])).load(reference)
    law = Heuristic(Q=ZeroPhaseButterworth(cutoff, LOG_PERIOD), gamma=0.9, delta=delta)
    trials = list(
        learn(_Plant(job), law, reference, iterations, output_of=lambda run: run.motor_angle)
    )
    sides = [_side(motion, trial.result) for trial in trials]
    error = np.array([trial.error for trial in trials])
    gear = model.drives.gear
    start, end = motion.contour_time
    end_of_motion = motion.rest_before + motion.timing.duration
    return {
        "motor_inf": np.array([measures.inf_norm(e) for e in error * gear]),
        "motor_two": np.array([measures.two_norm(e) for e in error * gear]),
        "arm_rms": np.array([side.rms for side in sides]),
        "arm_maxdev": np.array([side.maxdev for side in sides]),
        "ripple": np.array(
            [
                measures.circle_ripple(np.hypot(*side.path.T), end - start, *RIPPLE_BAND)
                for side in sides
            ]
        ),
        "error": error,
        "correction": np.array([trial.correction for trial in trials]),
        "gear": gear,
        "motion_end": np.array(np.searchsorted(motion.time, end_of_motion)),
    }


def _side(motion: ToolMotion, run: Recording) -> ArmSide:
    every = slice(None, None, _TRACKER_STRIDE)
    return arm_side(motion, run.truth.time[every], run.truth.tool_position[every])


def learning_checks(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Check]:
    """Motor side and arm side at 40 mm/s over poses, cutoff and shift: (a) to (d)."""
    run = partial(learned, model, effects)
    base = {pose: run(pose) for pose in POSES}
    yield from targets.motor_side(base)
    yield from targets.arm_side(base)
    fast = run("p1", cutoff=15.0)
    yield from targets.cutoff_arm(base["p1"], fast)
    yield from targets.cutoff_motor(base["p1"], fast)
    yield from targets.shift_arm(base, {pose: run(pose, delta=6) for pose in ("p1", "p2")})


def nominal_checks(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Check]:
    """Errors without learning by position and velocity: (f)."""
    at_10, at_50, at_80 = (
        {pose: learned(model, effects, pose, speed=speed, iterations=0) for pose in POSES}
        for speed in (0.010, 0.050, 0.080)
    )
    yield from targets.nominal_by_position(at_50)
    yield from targets.growth(at_10, at_80)


def model_checks(model: RobotModel, effects: frozenset[Effect]) -> Iterator[Check]:
    """The response to corrections of the motors that move most, at p1: (e)."""
    runs = {v: learned(model, effects, "p1", speed=1e-3 * v) for v in targets.SPEEDS}
    yield from targets.fitted_model(targets.identify(runs))


CHECKS: tuple[Callable[[RobotModel, frozenset[Effect]], Iterator[Check]], ...] = (
    learning_checks,
    nominal_checks,
    model_checks,
)
"""Those that exclude most candidates first."""
