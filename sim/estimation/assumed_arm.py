"""The arm as its owner assumes it: nominal data with stiffnesses that are wrong."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..robot.drives import EXACT, GearError
from ..robot.model import RobotModel
from .nominal import NominalArm, NominalCfg, nominal_arm

_STREAM = 0xA2  # of this draw, apart from those of individual and instruments


def assumed_arm(
    robot: RobotModel,
    stiffness_error: float,
    seed: int,
    *,
    gear_error: GearError = EXACT,
    **known: Any,
) -> NominalArm:
    """Nominal arm with the stiffness of each gear wrong by a uniform factor.

    Args:
        stiffness_error: relative, e.g. 0.3 for factors in 0.7 .. 1.3.
        gear_error: that was found in the robot's gears.
        known: further fields of `NominalCfg`.
    """
    rng = np.random.default_rng([seed, _STREAM])
    stiffness_error += 0.0  # no -0.0, from which to 0.0 is no range to numpy
    factors = 1.0 + rng.uniform(-stiffness_error, stiffness_error, robot.n_axes)
    arm = nominal_arm(robot, NominalCfg(stiffness=tuple(factors), **known))
    return replace(arm, gear_error=gear_error)
