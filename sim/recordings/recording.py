"""Recordings of real arms, in motion or of poses, and their plausibility for a robot."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits
from armside.kinematics.calibration import Measurements


@dataclass(frozen=True, eq=False)
class Stream:
    """Samples of one instrument by its own clock."""

    time: Array
    """(N,) [s], increasing; not evenly spaced."""
    values: Array
    """(N, m)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecording:
    """One recording of an arm of n motors in motion. The clocks need not agree."""

    name: str
    encoders: Stream
    """(N, n) [rad], motor angles on the arm side of the gear."""
    imu: Stream | None = None
    """(K, 6), specific force [m/s^2] and angular rate [rad/s] in the axes of the housing."""
    tracker: Stream | None = None
    """(L, 3) [m], a point fixed to the tool, in the frame of the instrument."""
    form: str
    notes: tuple[str, ...] = ()
    """What was repaired or converted, a line each."""


@dataclass(frozen=True, eq=False)
class PoseRecording:
    """Measured poses, and what was left out of them and why."""

    measurements: Measurements
    form: str
    """Name of the form that was recognised."""
    notes: tuple[str, ...] = ()
    """One line for each kind of row that was left out."""


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
