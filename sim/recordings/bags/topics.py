"""Choice of a bag's topics: one each for encoders and IMU, some for targets of a tracker."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ...records.files import InputError

NONE = "none"
"""Given in place of a topic: the instrument is not read."""
FRAME = "#"
"""Between a topic and the frame that is taken from it."""


class Instrument(NamedTuple):
    """Instrument of a recording: its option on the command line, and its types of messages."""

    name: str
    option: str
    types: tuple[str, ...]
    """That are looked for."""
    named: tuple[str, ...] = ()
    """That can be read, too, where a topic is named."""


ENCODERS = Instrument("encoders", "joint-topic", ("sensor_msgs/msg/JointState",))
IMU = Instrument("imu", "imu-topic", ("sensor_msgs/msg/Imu",))
_POINTS = tuple(f"geometry_msgs/msg/{name}Stamped" for name in ("Pose", "Point", "Transform"))
TRACKER = Instrument("tracker", "tracker-topic", _POINTS, ("tf2_msgs/msg/TFMessage",))


@dataclass(frozen=True, kw_only=True)
class BagTopics:
    """Topics of a bag, and names of joints; None and empty: those that are the only ones."""

    joint: str | None = None
    imu: str | None = None
    tracker: tuple[str, ...] = ()
    """TOPIC, or TOPIC#FRAME for one frame of several."""
    joints: tuple[str, ...] = ()
    """In the order of the robot's motors."""

    def __post_init__(self) -> None:
        for given in (self.joints, self.tracker):
            if twice := sorted({name for name in given if given.count(name) > 1}):
                raise ValueError(f"{twice[0]} is given twice")

    def asked(self, instrument: Instrument) -> tuple[str, ...]:
        """Topics that were named for an instrument."""
        if instrument is TRACKER:
            return self.tracker
        one = self.joint if instrument is ENCODERS else self.imu
        return () if one is None else (one,)

    @property
    def named(self) -> bool:
        """True where anything was chosen."""
        return self != BagTopics()


def choose(
    bag: str, types: Mapping[str, str], instrument: Instrument, asked: Sequence[str]
) -> tuple[str, ...]:
    """Topics (with their frames) of an instrument among those of a bag; empty where there are none.

    Raises InputError where one is not there or of another type, or several are and none is asked.
    """
    readable = (*instrument.types, *instrument.named)
    if tuple(asked) == (NONE,):
        return ()
    for name in asked:
        topic = name.partition(FRAME)[0]
        if topic not in types:
            fit = sorted(name for name, kind in types.items() if kind in readable) or "none fit"
            raise InputError(f"{bag} has no topic {topic} with messages. Topics: {fit}")
        if types[topic] not in readable:
            text = f"{topic} of {bag} holds {types[topic]}"
            raise InputError(f"{text}; --{instrument.option} takes {', '.join(readable)}")
    if asked:
        return tuple(asked)
    found = sorted(topic for topic, kind in types.items() if kind in instrument.types)
    if len(found) > 1:
        several = f"{bag} has {len(found)} topics for {instrument.name}: {', '.join(found)}"
        raise InputError(f"{several}; choose one by --{instrument.option}")
    return tuple(found)
