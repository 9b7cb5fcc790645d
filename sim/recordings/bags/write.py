"""A recording as a ROS 2 bag: a folder with an MCAP file and its metadata."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ...records.files import InputError
from ..recording import MotionRecording, Stream
from .messages import BILLION

TOPICS = {"encoders": "/joint_states", "imu": "/imu", "tracker": "/target"}
KINDS = {"encoders": "JointState", "imu": "Imu", "tracker": "PointStamped"}
UNKNOWN = np.zeros(9)
"""Covariance that is not known."""


def write_bag(folder: Path, recording: MotionRecording) -> None:
    """Write a new folder. Joints are named joint_1 and so on; stamps are rounded to nanoseconds.

    Raises InputError without the package rosbags.
    """
    try:
        rosbag2, typesys = (import_module(f"rosbags.{name}") for name in ("rosbag2", "typesys"))
    except ImportError as error:
        raise InputError("bags need the package rosbags: pip install 'armside[bags]'") from error
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    make = _Messages(store.types)
    plugin = rosbag2.StoragePlugin.MCAP
    with rosbag2.Writer(folder, version=9, storage_plugin=plugin) as bag:
        for name, topic in TOPICS.items():
            stream = getattr(recording, name)
            if stream is None:
                continue
            kind = make.full(KINDS[name])
            connection = bag.add_connection(topic, kind, typestore=store)
            for stamp, message in make.messages(name, stream):
                bag.write(connection, max(stamp, 0), store.serialize_cdr(message, kind))


class _Messages:
    """Messages of the samples of an instrument."""

    def __init__(self, types: Any) -> None:
        self.types = types
        self.names = {name.rpartition("/")[2]: name for name in types}

    def full(self, kind: str) -> str:
        """Full name of a type of message."""
        return self.names[kind]

    def messages(self, name: str, stream: Stream) -> Iterator[tuple[int, Any]]:
        """Stamp [ns] and message of each sample."""
        make = {"encoders": self._joints, "imu": self._imu, "tracker": self._point}[name]
        for time, values in zip(stream.time, stream.values, strict=True):
            stamp = round(BILLION * float(time))
            yield stamp, make(self._header(stamp, name), values)

    def _new(self, kind: str, *values: Any) -> Any:
        return self.types[self.full(kind)](*values)

    def _header(self, stamp: int, frame: str) -> Any:
        return self._new("Header", self._new("Time", *divmod(stamp, BILLION)), frame)

    def _joints(self, header: Any, values: Any) -> Any:
        names = [f"joint_{i}" for i in range(1, len(values) + 1)]
        own, none = np.ascontiguousarray(values), np.empty(0)
        return self._new("JointState", header, names, own, none, none)

    def _imu(self, header: Any, values: Any) -> Any:
        force, rate = (self._new("Vector3", *part.tolist()) for part in (values[:3], values[3:]))
        no_orientation = np.r_[-1.0, np.zeros(8)]
        turn = self._new("Quaternion", 0.0, 0.0, 0.0, 1.0)
        return self._new("Imu", header, turn, no_orientation, rate, UNKNOWN, force, UNKNOWN)

    def _point(self, header: Any, values: Any) -> Any:
        return self._new("PointStamped", header, self._new("Point", *values.tolist()))
