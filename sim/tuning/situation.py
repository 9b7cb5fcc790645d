"""Where an episode stands: what the last run left behind, and how one more iteration changes it."""

import copy
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ilc.measures import two_norm
from kinematics import CompiledRobot
from kinematics import compile as compile_robot

from ..arm_side import ArmSide, arm_side
from ..cell import CELLS
from ..cutting import Pass
from ..experiment import Experiment
from ..recording import Array
from .design import Design

DIVERGED = 3.0
"""Of its value at k = 0: a motor's 2-norm beyond it has diverged, as in `ilc.learning.learn`."""


@dataclass(frozen=True, kw_only=True)
class Situation:
    """After run k of an experiment."""

    experiment: Experiment
    k: int
    correction: Array = field(repr=False)
    """u_k, (N, 6) [rad], arm side."""
    error: Array = field(repr=False)
    """e_k, (N, 6) [rad], arm side."""
    first_norm: Array
    """(6,), 2-norms of e_0 [rad]."""
    seen: ArmSide
    """The tool as the configured sensor has it."""
    true: ArmSide
    """The tool as it was: for evaluation only."""
    diverged: bool
    limits_hit: tuple[tuple[str, int, float], ...]


Sensor = Callable[[Experiment, Pass], ArmSide]


def by_tracker(experiment: Experiment, cut: Pass) -> ArmSide:
    """What the laser tracker says of the tool."""
    seen = cut.tracker
    return arm_side(experiment.motion, seen.time, seen.position)


@lru_cache
def by_motors(robot: str) -> Sensor:
    """What the motor angles would say of the tool if nothing between them and it gave way."""
    arm: CompiledRobot = compile_robot(CELLS[robot].robot)

    def sensor(experiment: Experiment, cut: Pass) -> ArmSide:
        recording, motion = cut.recording, experiment.motion
        asked, got = (
            arm.pose(phi)[:, :3, 3] for phi in (recording.reference, recording.motor_angle)
        )
        # r is shifted against the deflection that the controller expects: compare with r, not with
        # the programmed path.
        tool = motion.position + got - asked
        return arm_side(motion, recording.time, tool)

    return sensor


def begin(experiment: Experiment, sensor: Sensor) -> Situation:
    """Run once without learning: k = 0."""
    return _situation(experiment, sensor, 0, np.zeros_like(experiment.job.reference), None)


def advance(situation: Situation, design: Design, sensor: Sensor) -> Situation:
    """Learn once with a design and run again."""
    correction = design.law(situation.correction, situation.error)
    return _situation(
        situation.experiment, sensor, situation.k + 1, correction, situation.first_norm
    )


def restarted(situation: Situation) -> Situation:
    """The same situation with a noise source of its own: what follows can be run again, alike."""
    plant = situation.experiment.plant
    plant = replace(plant, rng=copy.deepcopy(plant.rng))
    return replace(situation, experiment=replace(situation.experiment, plant=plant))


def _situation(
    experiment: Experiment,
    sensor: Sensor,
    k: int,
    correction: Array,
    first_norm: Array | None,
) -> Situation:
    cut = experiment.plant.run(correction)
    truth = cut.recording.truth
    tracker_stride = round(
        1.0 / (experiment.plant.tracker.cfg.rate * experiment.job.model.timestep)
    )
    time, position = truth.time[::tracker_stride], truth.tool_position[::tracker_stride]
    error = cut.recording.error
    norm = two_norm(error)
    if first_norm is None:
        first_norm = norm
    diverged = not np.isfinite(error).all() or bool((norm > DIVERGED * first_norm).any())
    return Situation(
        experiment=experiment,
        k=k,
        correction=correction,
        error=error,
        first_norm=first_norm,
        seen=sensor(experiment, cut),
        true=arm_side(experiment.motion, time, position),
        diverged=diverged,
        limits_hit=cut.recording.limits_hit,
    )
