"""Choice of a bag's topics: one each for encoders and IMU, some for targets of a tracker."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from ...records.files import InputError

NONE = "none"
"""Given in place of a topic: the instrument is not read."""
FRAME = "#"
"""Between a topic and the frame that is taken from it."""
TF = "tf2_msgs/msg/TFMessage"


class Instrument(Enum):
    """Instrument of a recording: its option on the command line, and its types of messages."""

    ENCODERS = ("joint-topic", ("sensor_msgs/msg/JointState",))
    IMU = ("imu-topic", ("sensor_msgs/msg/Imu",))
    TRACKER = (
        "tracker-topic",
        tuple(f"geometry_msgs/msg/{name}Stamped" for name in ("Pose", "Point", "Transform")),
    )

    @property
    def option(self) -> str:
        """Name of the option without dashes."""
        return self.value[0]

    @property
    def types(self) -> tuple[str, ...]:
        """Types of messages that are looked for."""
        return self.value[1]

    @property
    def readable(self) -> tuple[str, ...]:
        """Types of messages that can be read where a topic is named."""
        return (*self.types, TF) if self is Instrument.TRACKER else self.types


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
        if instrument is Instrument.TRACKER:
            return self.tracker
        one = self.joint if instrument is Instrument.ENCODERS else self.imu
        return () if one is None else (one,)

    @property
    def named(self) -> bool:
        """True where anything was chosen."""
        return self != BagTopics()


def choose(
    bag: str, types: Mapping[str, str], instrument: Instrument, asked: Sequence[str]
) -> tuple[str, ...]:
    """Topics (with their frames) of an instrument; empty where there are none.

    Args:
        bag: its name, for messages.
        types: of the messages of each topic that has any.
        asked: topics named by the user.

    Raises:
        InputError: a topic is not there or of another type, or several are and none is named.
    """
    if tuple(asked) == (NONE,):
        return ()
    for name in asked:
        _check(bag, types, instrument, name.partition(FRAME)[0])
    if asked:
        return tuple(asked)
    found = sorted(topic for topic, kind in types.items() if kind in instrument.types)
    if len(found) > 1:
        choice = f"choose one by --{instrument.option}"
        kinds = instrument.name.lower()
        raise InputError(f"{bag} has {len(found)} topics for {kinds}: {', '.join(found)}; {choice}")
    return tuple(found)


def _check(bag: str, types: Mapping[str, str], instrument: Instrument, topic: str) -> None:
    wanted = ", ".join(instrument.readable)
    if topic not in types:
        fit = sorted(name for name, kind in types.items() if kind in instrument.readable)
        raise InputError(f"{bag} has no topic {topic} with messages. Topics: {fit or 'none fit'}")
    if types[topic] not in instrument.readable:
        text = f"{topic} of {bag} holds {types[topic]}"
        raise InputError(f"{text}; --{instrument.option} takes {wanted}")
