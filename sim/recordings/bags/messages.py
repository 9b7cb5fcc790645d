"""Topics of a bag, one each for encoders and IMU, some for targets, and their messages as numbers.

Units are those of ROS (REP 103): rad, m, m/s^2, rad/s; quaternions there have w last.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array

from ...records.files import InputError, check_file, reading

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


BILLION = 1_000_000_000


class Joints(NamedTuple):
    """One sensor_msgs/JointState."""

    stamp: int
    """[ns], of the header."""
    names: tuple[str, ...]
    position: Array
    """[rad], one for each name; empty where the message has none."""


class Sample(NamedTuple):
    """One sample of an IMU, or of a point."""

    stamp: int
    """[ns], of the header."""
    frame: str
    """Frame of the header: of the housing, or that positions are given in."""
    child: str
    """Frame that was measured, where the message names one."""
    values: tuple[float, ...]
    """Specific force and angular rate; or position and, where there is one, quaternion, w first."""


_vector, _turn = attrgetter("x", "y", "z"), attrgetter("w", "x", "y", "z")


def joints(message: Any) -> Joints:
    """Angles of a sensor_msgs/JointState."""
    position = np.asarray(message.position, dtype=np.float64)
    return Joints(_stamp(message.header), tuple(message.name), position)


def samples(kind: str, message: Any) -> Iterator[Sample]:
    """Samples of a message of another type: one, or of TFMessage one for each frame."""
    kind, child = kind.rpartition("/")[2], ""
    if kind == "TFMessage":
        for one in message.transforms:
            yield from samples("TransformStamped", one)
        return
    if kind == "Imu":
        values = _reading(message, "linear_acceleration") + _reading(message, "angular_velocity")
    elif kind == "PoseStamped":
        values = _vector(message.pose.position) + _turn(message.pose.orientation)
    elif kind == "PointStamped":
        values = _vector(message.point)
    else:
        moved, child = message.transform, message.child_frame_id
        values = _vector(moved.translation) + _turn(moved.rotation)
    yield Sample(_stamp(message.header), message.header.frame_id, child, values)


def _reading(imu: Any, name: str) -> tuple[float, ...]:
    """One vector; NaN where the driver says by -1 that it has none."""
    absent = getattr(imu, f"{name}_covariance")[0] == -1.0
    return (np.nan,) * 3 if absent else _vector(getattr(imu, name))


def _stamp(header: Any) -> int:
    return BILLION * int(header.stamp.sec) + int(header.stamp.nanosec)


SUFFIXES = (".mcap", ".db3", ".bag")
METADATA = "metadata.yaml"
LARGEST_METADATA = 4_000_000
"""[bytes]"""
LARGEST_BAG = 10**12
"""[bytes], of a file: only chosen topics are kept in memory."""
MOST_MESSAGES = 4_000_000
"""Of the chosen topics together."""


@dataclass(frozen=True, eq=False)
class Messages:
    """Samples of the chosen topics of a bag, in the order of the file."""

    encoders: dict[str, list[Joints]]
    imu: dict[str, list[Sample]]
    tracker: dict[str, list[Sample]]


def is_bag(path: Path) -> bool:
    """True for a file with a bag's suffix, and for a folder with the metadata of one."""
    if path.is_dir():
        return (path / METADATA).is_file()
    return path.suffix.lower() in SUFFIXES


def read_messages(path: Path, topics: BagTopics) -> Messages:
    """Messages of the chosen topics. Raises InputError for a bag that is damaged, without encoders
    or too long, topics that are ambiguous, and without the package rosbags."""
    for file in path.iterdir() if path.is_dir() else [path]:
        check_file(file, LARGEST_METADATA if file.name == METADATA else LARGEST_BAG)
    with _opened(path) as bag:
        chosen = _chosen(path.name, bag, topics)
        wanted = {name.partition(FRAME)[0] for names in chosen.values() for name in names}
        connections = [one for one in bag.connections if one.topic in wanted]
        if (n := sum(one.msgcount for one in connections)) > MOST_MESSAGES:
            raise InputError(f"{path.name}: {n} messages; at most {MOST_MESSAGES} can be used")
        return _collected(bag, connections, chosen)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    try:
        highlevel, typesys = (import_module(f"rosbags.{name}") for name in ("highlevel", "typesys"))
    except ImportError as error:
        needed = "the package rosbags: pip install 'armside[bags]'"
        raise InputError(f"{path.name}: bags need {needed}") from error
    # Bags before ROS 2 Iron hold no definitions of their messages.
    types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    with reading(path), highlevel.AnyReader([path], default_typestore=types) as bag:
        yield bag


def _chosen(name: str, bag: Any, topics: BagTopics) -> dict[Instrument, tuple[str, ...]]:
    infos = ((topic, info) for topic, info in bag.topics.items() if info.msgcount)
    known = {topic: info.msgtype or "several types" for topic, info in infos}
    found = {one: choose(name, known, one, topics.asked(one)) for one in (ENCODERS, IMU, TRACKER)}
    if not found[ENCODERS]:
        listed = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(known.items())) or "none"
        raise InputError(f"{name} has no messages of {ENCODERS.types[0]}. Topics: {listed}")
    return found


def _collected(
    bag: Any, connections: list[Any], chosen: dict[Instrument, tuple[str, ...]]
) -> Messages:
    angles: dict[str, list[Joints]] = {name: [] for name in chosen[ENCODERS]}
    names = (*chosen[IMU], *chosen[TRACKER])
    others: dict[str, list[Sample]] = {name.partition(FRAME)[0]: [] for name in names}
    for connection, _, raw in bag.messages(connections):
        message = bag.deserialize(raw, connection.msgtype)
        if connection.topic in angles:
            angles[connection.topic].append(joints(message))
        else:
            others[connection.topic] += samples(connection.msgtype, message)
    imu = {name: others[name] for name in chosen[IMU]}
    return Messages(angles, imu, {name: _of_frame(name, others) for name in chosen[TRACKER]})


def _of_frame(name: str, found: dict[str, list[Sample]]) -> list[Sample]:
    """Samples of TOPIC, or of TOPIC#FRAME those that measured the frame."""
    topic, named, frame = name.partition(FRAME)
    if not named:
        return found[topic]
    children = sorted({one.child for one in found[topic]})
    if frame not in children:
        raise InputError(f"{topic} has no frame {frame}. Frames: {', '.join(children)}")
    return [one for one in found[topic] if one.child == frame]
