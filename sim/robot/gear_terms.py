"""Known transmission error of a robot's gears, from the terms of its robot file.

output = motor + epsilon(motor),   epsilon_j(phi) = sum of amplitude sin(order phi + phase)
"""

from collections.abc import Sequence

import numpy as np

from armside.kinematics.robot_file import GearTerm

from .drives import GearError


def gear_error_of(terms: Sequence[GearTerm], n_axes: int) -> GearError:
    """Transmission error with these terms; joints of fewer terms than others have zeros.

    Raises ValueError for a term of a joint that the robot does not have.
    """
    own: list[list[GearTerm]] = [[] for _ in range(n_axes)]
    for term in terms:
        if not 1 <= term.joint <= n_axes:
            raise ValueError(f"gear error of joint {term.joint}: the robot has {n_axes} joints")
        own[term.joint - 1].append(term)
    shape = n_axes, max(1, *map(len, own))
    amplitude, order, phase = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for i, of_joint in enumerate(own):
        for h, term in enumerate(of_joint):
            amplitude[i, h], order[i, h], phase[i, h] = term[2], term[1], term[3]
    return GearError(amplitude=amplitude, order=order, phase=phase)
