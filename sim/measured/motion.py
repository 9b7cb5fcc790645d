"""Recording of an arm in motion: encoders, IMU and tracker, each by its own clock."""

from dataclasses import dataclass

from armside.arrays import Array


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
