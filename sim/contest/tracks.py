"""The tracks by name."""

from ..records.files import InputError
from .joint_track import TRACK as JOINT
from .task import Track

NAMES = ("joint", "motor", "imu", "tracker", "first", "drift", "part")


def track(name: str) -> Track:
    """Raises InputError for an unknown name."""
    if name == "joint":
        return JOINT
    if name not in NAMES:
        raise InputError(f"Unknown track {name!r}. Tracks: {', '.join(NAMES)}")
    from .robot_tracks import TRACKS  # the others need MuJoCo

    return TRACKS[name]
