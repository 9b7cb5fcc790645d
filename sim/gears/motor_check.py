"""Motors of a recording whose angles cannot be theirs: swapped, reversed, or not logged.

The magnitude of the tool's angular velocity by the encoders is held against that of the gyro, which
needs neither mounting nor frames. Only where the two are unlike are other assignments tried.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..measured.motion import Stream
from .joint_motion import JointMotion
from .lag import likeness_at_best_lag

ALIKE = 0.999
"""Correlation from which motors are taken as right; the AUBO's days have 0.9996."""
UNLIKE = 0.99
"""Correlation below which a motor that does not move is taken as one that is not logged. ESTIMATE:
the AUBO with one motor held has 0.986 to 0.991."""
BETTER = 0.5
"""Fraction of the unlikeness that another assignment may leave to be named."""
STILL = 1e-4
"""[rad] Range of a motor that does not move."""
STRIDE = 5
"""Samples of the grid for one of the comparison."""


def check_motors(robot: CompiledRobot, motion: JointMotion, imu: Stream) -> None:
    """Raise ValueError, naming them, for motors that the gyro contradicts."""
    rows = slice(None, None, STRIDE)
    time, phi, rate = motion.time[rows], motion.phi[rows], motion.rate[rows]
    seen = imu.time, np.linalg.norm(imu.values[:, 3:], axis=1)
    n = phi.shape[1]

    def likeness(order: list[int], sign: Array) -> float:
        J = robot.jacobian(np.ascontiguousarray(phi[:, order] * sign))
        omega = np.einsum("nij,nj->ni", J[:, 3:], rate[:, order] * sign)
        return likeness_at_best_lag(seen, (time, np.linalg.norm(omega, axis=1)))

    if (given := likeness(list(range(n)), np.ones(n))) >= ALIKE:
        return
    still = np.flatnonzero(np.ptp(motion.phi, axis=0) < STILL)
    if len(still) and given < UNLIKE:
        text = f"does not move, and the gyro does not fit the others (correlation {given:.3f})"
        raise ValueError(f"motor_angle_{still[0] + 1} {text}")
    found = {said: likeness(order, sign) for said, order, sign in _others(n)}
    best = max(found.values(), default=given)
    if 1.0 - best < BETTER * (1.0 - given):
        equal = [said for said, like in found.items() if 1.0 - like < 1.1 * (1.0 - best)]
        text = f"the gyro fits them with a correlation of {given:.3f}, and of {best:.4f} with"
        raise ValueError(f"motors are not those of the robot: {text} {' or '.join(equal)}")


def _others(n: int) -> Iterator[tuple[str, list[int], Array]]:
    for j in range(n):
        yield f"the sign of motor {j + 1} reversed", list(range(n)), 1.0 - 2.0 * np.eye(n)[j]
    for i, j in combinations(range(n), 2):
        order = list(range(n))
        order[i], order[j] = j, i
        yield f"motors {i + 1} and {j + 1} swapped", order, np.ones(n)
