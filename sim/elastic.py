"""What the controller anticipates of the arm's elasticity: a shift of the programmed path."""

import numpy as np

from .model import RobotModel
from .recording import Array
from .servo import interpolate
from .statics import Statics

BOX = 5
"""Samples of the moving average that `smoothed` takes twice: that of the study which calibrated the
large robot, 20 ms at the log rate. ESTIMATE."""


def anticipated_shift(model: RobotModel, phi: Array, period: float) -> Array:
    """The share of the quasi-static elastic deflection that the reference is to counteract.

    The controller of the robot knows its elasticity with too stiff a model: it expects only
    `Drives.elastic_compensation` of the deflection that gravity and the rigid motion cause.

    Args:
        model: the robot as its controller knows it.
        phi: (N, 6) [rad], motor angles of the programmed path, every `period` [s].

    Returns:
        (N, 3) [m], base axes, to be subtracted from the programmed tool positions.
    """
    _, phi_dot, phi_ddot = interpolate(phi, period, 1)
    statics = Statics(model)
    forces = statics.rigid_forces(phi, phi_dot, phi_ddot)
    return model.drives.elastic_compensation * statics.deflection(phi, forces)


def smoothed(shift: Array) -> Array:
    """A shift (N, 3) [m] without the steps it makes where the curvature of a contour jumps.

    There the acceleration jumps, and with it the expected deflection. No controller has its motors
    follow that within one sample.
    """
    kernel = np.convolve(np.ones(BOX), np.ones(BOX)) / BOX**2
    edge = len(kernel) // 2
    padded = np.pad(shift, ((edge, edge), (0, 0)), mode="edge")
    return np.column_stack([np.convolve(column, kernel, mode="valid") for column in padded.T])
