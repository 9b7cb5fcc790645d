"""Messages of a bag by instrument, for chosen topics; other topics are not decoded."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ...records.files import InputError, check_file, reading
from .messages import Joints, Sample, joints, samples
from .topics import FRAME, BagTopics, Instrument, choose

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


def recognised(path: Path) -> bool:
    """True for a file with a bag's suffix, and for a folder with the metadata of one."""
    if path.is_dir():
        return (path / METADATA).is_file()
    return path.suffix.lower() in SUFFIXES


def read_messages(path: Path, topics: BagTopics) -> Messages:
    """Messages of the chosen topics.

    Raises:
        InputError: damaged, without encoders, too long, or topics that are ambiguous; and without
            the package rosbags.
    """
    _check_files(path)
    with _opened(path) as bag:
        chosen = _chosen(path.name, bag, topics)
        wanted = {name.partition(FRAME)[0] for names in chosen.values() for name in names}
        connections = [one for one in bag.connections if one.topic in wanted]
        if (n := sum(one.msgcount for one in connections)) > MOST_MESSAGES:
            raise InputError(f"{path.name}: {n} messages; at most {MOST_MESSAGES} can be used")
        return _collected(bag, connections, chosen)


def _check_files(path: Path) -> None:
    """Raise InputError for what is no regular file."""
    files = [path] if not path.is_dir() else [*path.iterdir()]
    for file in files:
        check_file(file, LARGEST_METADATA if file.name == METADATA else LARGEST_BAG)


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
    types = {topic: info.msgtype or "several types" for topic, info in bag.topics.items()}
    known = {topic: kind for topic, kind in types.items() if bag.topics[topic].msgcount}
    found = {one: choose(name, known, one, topics.asked(one)) for one in Instrument}
    if not found[Instrument.ENCODERS]:
        listed = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(known.items()))
        wanted = Instrument.ENCODERS.types[0]
        raise InputError(f"{name} has no messages of {wanted}. Topics: {listed or 'none'}")
    return found


def _collected(
    bag: Any, connections: list[Any], chosen: dict[Instrument, tuple[str, ...]]
) -> Messages:
    angles: dict[str, list[Joints]] = {name: [] for name in chosen[Instrument.ENCODERS]}
    others: dict[str, list[Sample]] = {
        name.partition(FRAME)[0]: []
        for one in (Instrument.IMU, Instrument.TRACKER)
        for name in chosen[one]
    }
    for connection, _, raw in bag.messages(connections):
        message = bag.deserialize(raw, connection.msgtype)
        if connection.topic in angles:
            angles[connection.topic].append(joints(message))
        else:
            others[connection.topic] += samples(connection.msgtype, message)
    imu = {name: others[name] for name in chosen[Instrument.IMU]}
    return Messages(angles, imu, {n: _of_frame(n, others) for n in chosen[Instrument.TRACKER]})


def _of_frame(name: str, found: dict[str, list[Sample]]) -> list[Sample]:
    """Samples of TOPIC, or of TOPIC#FRAME those that measured the frame."""
    topic, named, frame = name.partition(FRAME)
    if not named:
        return found[topic]
    children = sorted({one.child for one in found[topic]})
    if frame not in children:
        raise InputError(f"{topic} has no frame {frame}. Frames: {', '.join(children)}")
    return [one for one in found[topic] if one.child == frame]
