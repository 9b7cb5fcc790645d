"""Plausibility of a recording for the robot that it is said to be of."""

import numpy as np

from armside.kinematics import Limits

from .motion import MotionRecording

OUT_OF_RANGE = 1.1
"""Motor angle relative to its limit from which the unit is doubted."""

SHORTEST = 10.0
"""[s] Of a recording from which clocks and mountings can be found. ESTIMATE."""
LONGEST_GAP = 1.0
"""[s] Without samples, which a spline may bridge. ESTIMATE: robots of this size move at 0.1 to
1 Hz; the recordings of an AUBO i5 have gaps up to 0.12 s."""


def check_times(recording: MotionRecording) -> None:
    """Raise ValueError for recordings that are too short, or that lack a stretch."""
    for name in ("encoders", "imu"):
        stream = getattr(recording, name)
        if stream is None:
            continue
        if (length := stream.time[-1] - stream.time[0]) < SHORTEST:
            text = f"{length:.3g} s of samples; at least {SHORTEST:g} s are needed"
            raise ValueError(f"{recording.name}: {name}: {text}")
        longest = int(np.diff(stream.time).argmax())
        if (gap := np.diff(stream.time)[longest]) > LONGEST_GAP:
            text = f"no samples for {gap:.3g} s after {stream.time[longest]:.4g} s by its clock"
            raise ValueError(f"{recording.name}: {name}: {text}; cut the recording there")


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
