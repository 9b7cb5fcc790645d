"""Robot individuals: the same design with slightly other parameters."""

import copy
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .model import AXES, RobotModel

# dcmotor keeps Coulomb and static LuGre friction here (checked by a test against the MJCF).
_COULOMB, _STATIC = 3, 4


def with_friction(model: RobotModel, factor: ArrayLike) -> RobotModel:
    """The robot with Coulomb and static friction scaled.

    factor: one for all axes or (6,), > 0.
    """
    factor = np.broadcast_to(np.asarray(factor, dtype=np.float64), (len(AXES),))
    if not (np.isfinite(factor).all() and (factor > 0.0).all()):
        raise ValueError(f"friction factors must be > 0, got {factor.tolist()}")
    mj = copy.copy(model.mj)
    axes = [mj.actuator(f"axis_{i}").id for i in AXES]
    mj.actuator_biasprm[axes, _COULOMB] *= factor
    mj.actuator_biasprm[axes, _STATIC] *= factor
    return replace(model, mj=mj)


def braked_at(model: RobotModel, phi: ArrayLike) -> RobotModel:
    """The robot with its brakes set to hold the motors at phi, (6,) [rad], once they engage.

    Raises ValueError for a robot without brakes.
    """
    if not len(model.brakes):
        raise ValueError("this robot has no brakes: its model lacks the equalities brake_1..6")
    mj = copy.copy(model.mj)
    mj.eq_data[model.brakes, 0] = phi
    return replace(model, mj=mj)
