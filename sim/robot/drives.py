"""Friction as a controller anticipates it: a share of what it knows of its drives' friction."""

import numpy as np

from armside.arrays import Array

from .model import Drives

FRICTION_SPEED = 0.02
"""[rad/s], arm side: below it, friction feedforward fades to zero. ESTIMATE."""


def friction_torque(drives: Drives, velocity: Array) -> Array:
    """(M, 6) [N m], arm side: the share of friction that the controller anticipates.

    Coulomb friction; for a controller that knows the whole curve of its drives also
    (F_s - F_c) exp(-(v / v_s)^2) in addition to it, and viscous friction.

    velocity: (M, 6) [rad/s], of the reference.
    """
    share = drives.friction_feedforward
    fade = np.tanh(velocity / FRICTION_SPEED)
    torque = share * drives.coulomb_friction * drives.gear * fade
    if not drives.friction_curve:
        return torque
    of_motor = drives.gear * velocity
    excess = drives.static_friction - drives.coulomb_friction
    stribeck = excess * np.exp(-((of_motor / drives.stribeck_speed) ** 2))
    return torque + share * drives.gear * (stribeck * fade + drives.viscous_friction * of_motor)
