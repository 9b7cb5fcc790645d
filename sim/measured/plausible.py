"""Plausibility of a recording for the robot that it is said to be of."""

import numpy as np

from armside.kinematics import Limits

from .motion import MotionRecording

OUT_OF_RANGE = 1.1
"""Motor angle relative to its limit from which the unit is doubted."""


def check_angles(limits: Limits, recording: MotionRecording) -> None:
    """Raise ValueError for motor angles that are far out of range: degrees, or another robot."""
    angles = np.abs(recording.encoders.values).max(axis=0)
    bound = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
    if angles.shape != bound.shape:
        text = f"the robot has {len(bound)} motors, the recording has {len(angles)}"
        raise ValueError(f"{recording.name}: {text}")
    worst = int((angles / bound).argmax())
    if angles[worst] > OUT_OF_RANGE * bound[worst]:
        unit = "are the angles in degrees?"
        if angles[worst] < 2.0 * bound[worst]:
            unit = "is it this robot?"
        text = f"reaches {angles[worst]:.3g}, its limit is {bound[worst]:.3g} rad; {unit}"
        raise ValueError(f"{recording.name}: motor_angle_{worst + 1} {text}")
