"""Checks of an IMU and of motors: units, axes and columns that cannot be right are named.

Each raises ValueError with what is wrong. Motors that are swapped, reversed or not logged show in
the magnitude of the tool's angular velocity by the encoders beside that of the gyro, which needs
neither mounting nor frames. Only where the two are unlike are other assignments tried.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..recorded_motion import Stream
from .encoder_motion import EncoderMotion, likeness_at_best_lag

SCALE = (0.5, 2.0)
"""Singular values of M of a sensor in SI units. ESTIMATE: beyond it the unit is wrong."""
UNITS = (
    ("angular rate", "degrees per second", 180.0 / np.pi),
    ("specific force", "g", 1.0 / 9.81),
    ("specific force", "mm/s^2", 1e3),
)
APART = np.radians(20.0)
"""[rad] Between the axes of the two sensors of one housing. ESTIMATE: 0.9 degrees on an AUBO i5."""
BIAS = 3.0
"""[m/s^2] Bias of an accelerometer. ESTIMATE: sensors have tenths; without gravity it is 9.8."""
COLUMNS = tuple(f"{name}_{a}" for name in ("acceleration", "angular_velocity") for a in "xyz")


def check_readings(imu: Stream) -> None:
    """Refuse columns that never change, and the two sensors in each other's place."""
    if still := [name for name, x in zip(COLUMNS, imu.values.T, strict=True) if np.ptp(x) == 0.0]:
        raise ValueError(f"IMU: {', '.join(still)} never changes")
    halves = imu.values.reshape(-1, 2, 3)
    force, rate = np.median(np.linalg.norm(halves, axis=2), axis=0)
    if force < 5.0 < rate < 20.0:
        said = f"{force:.2g} m/s^2 and {rate:.2g} rad/s in the median"
        raise ValueError(f"IMU: accelerations and angular velocities are exchanged: {said}")


def check_sensor(quantity: str, M: Array) -> None:
    """Refuse a sensor whose matrix M (3, 3) is of another unit, singular or left-handed."""
    values = np.linalg.svd(M)[1]
    if not (SCALE[0] <= values.min() and values.max() <= SCALE[1]):
        typical = float(np.median(values))
        for name, unit, factor in UNITS:
            if name == quantity and 0.5 < typical / factor < 2.0:
                text = f"{quantity} is {typical:.3g} times as large"
                raise ValueError(f"IMU: {text}: is it in {unit}?")
        text = f"singular values {', '.join(f'{value:.3g}' for value in values)}"
        raise ValueError(f"IMU: {quantity} does not fit the motion: {text}, where 1 is expected")
    if np.linalg.det(M) < 0.0:
        said = "two are exchanged, or one has the wrong sign"
        raise ValueError(f"IMU: axes of the {quantity} are left-handed: {said}")


def check_pair(M_gyro: Array, M_accelerometer: Array, bias: Array) -> None:
    """Refuse sensors whose axes differ, and an accelerometer (bias (3,) [m/s^2]) sans gravity."""
    u, _, vt = np.linalg.svd(M_gyro @ M_accelerometer.T)
    angle = float(np.arccos(np.clip((np.trace(u @ vt) - 1.0) / 2.0, -1.0, 1.0)))
    if angle > APART:
        said = f"differ by {np.degrees(angle):.0f} degrees: are columns exchanged?"
        raise ValueError(f"IMU: axes of the specific force and of the angular rate {said}")
    if (size := float(np.linalg.norm(bias))) > BIAS:
        said = "is gravity taken out? 9.8 m/s^2 are expected at rest"
        raise ValueError(f"IMU: the accelerometer is off by {size:.2g} m/s^2: {said}")


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


def check_motors(robot: CompiledRobot, motion: EncoderMotion, imu: Stream) -> None:
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
        order = [{i: j, j: i}.get(k, k) for k in range(n)]
        yield f"motors {i + 1} and {j + 1} swapped", order, np.ones(n)
