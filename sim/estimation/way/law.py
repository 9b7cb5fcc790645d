"""Learning law of a long way: the regularised inverse of the arm at places along it."""

from dataclasses import replace

import numpy as np

from armside.arrays import Array
from armside.ilc.laws import Law
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse
from armside.ilc.laws.wrappers import Guarded

from ...robot.model import RobotModel
from ...robot.virtual_robot import LOG_PERIOD
from ..arm_plant import ArmPlant
from ..tool_law import ToolLaw, pass_band
from .deflection import deflection
from .elasticity import Elasticity
from .identification import linearised
from .rigid_motion import RigidMotion, segments

CUTOFF = 13.0
"""Least cutoff of Q [Hz]: springs in series hold up to higher frequencies than those of one place,
and corners need them."""
PLACE = 0.15
"""Change of a motor angle within which one inverse serves [rad]."""


def plants(
    robot: RobotModel, motion: RigidMotion, springs: Elasticity
) -> tuple[tuple[ArmPlant, ...], np.ndarray]:
    """Plants (S,) at places along a motion, and the samples (S,) of these places."""
    place = segments(motion.phi, PLACE)
    samples = np.array([int(np.flatnonzero(place == s).mean()) for s in range(place[-1] + 1)])
    angle = deflection(motion, springs).angle
    arms = [
        linearised(motion, used(springs, angle[place == s]), int(motion.segment[at]))
        for s, at in enumerate(samples)
    ]
    return tuple(ArmPlant(robot=robot, arm=arm, period=LOG_PERIOD) for arm in arms), samples


def used(springs: Elasticity, angle: Array) -> Elasticity:
    """Springs with their mean slope over deflections (M, n): within its lost motion one is soft."""
    inside = (np.abs(angle) < springs.lost_motion).mean(axis=0)
    return replace(springs, stiffness=springs.stiffness * (1.0 - inside * springs.softening))


def scheduled(
    law: ToolLaw,
    known: tuple[tuple[ArmPlant, ...], np.ndarray],
    motion: RigidMotion,
    turn_rate: float,
    *,
    rotations: bool = True,
) -> Law:
    """The law of `ToolLaw` on plants along a motion, as `ToolLaw.law` has it for one place.

    Raises ValueError for design variables out of range.
    """
    each, samples = known
    if law.cutoff is None:
        law = replace(law, cutoff=max(CUTOFF, pass_band(turn_rate)))
    inverses = tuple(_inverse(law, plant, turn_rate, rotations) for plant in each)
    weights = fading(motion.time[samples], motion.time)
    chosen = ScheduledInverse(laws=inverses, weights=weights)
    weight = inverses[len(inverses) // 2].output_weight
    return Guarded(law=chosen, weight=weight) if law.guarded else chosen


def _inverse(
    law: ToolLaw, plant: ArmPlant, turn_rate: float, rotations: bool
) -> RegularisedInverse:
    inverse = replace(law, guarded=False).law(plant, turn_rate, rotations=rotations)
    if not isinstance(inverse, RegularisedInverse):
        raise ValueError(f"a law on a schedule is the inverse, got {law.kind.value}")
    return inverse


def fading(centres: Array, time: Array) -> Array:
    """(N, S) weights at times (N,) that fade linearly between centres (S,), ascending."""
    return np.stack([np.interp(time, centres, row) for row in np.eye(len(centres))], axis=1)
