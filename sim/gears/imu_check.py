"""Checks of an IMU: units, gravity, axes and columns that cannot be right are named.

Each raises ValueError with what is wrong.
"""

import numpy as np

from armside.arrays import Array

from ..measured.motion import Stream

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
    force, rate = (
        float(np.median(np.linalg.norm(imu.values[:, i : i + 3], axis=1))) for i in (0, 3)
    )
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
                raise ValueError(
                    f"IMU: {quantity} is {typical:.3g} times as large: is it in {unit}?"
                )
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
