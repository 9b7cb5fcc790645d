"""A recording as a ROS 2 bag: a folder with an MCAP file and its metadata."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ...records.files import InputError
from ..recorded_motion import MotionRecording, Stream
from .messages import BILLION


def write_bag(folder: Path, recording: MotionRecording) -> None:
    """Write a new folder. Joints are named joint_1 and so on; stamps are rounded to nanoseconds.

    Raises InputError without the package rosbags.
    """
    try:
        rosbag2, typesys = (import_module(f"rosbags.{name}") for name in ("rosbag2", "typesys"))
    except ImportError as error:
        raise InputError("bags need the package rosbags: pip install 'armside[bags]'") from error
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    full = {name.rpartition("/")[2]: name for name in store.types}

    def new(kind: str, *values: Any) -> Any:
        return store.types[full[kind]](*values)

    with rosbag2.Writer(folder, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
        for name, (topic, kind, values_of) in MESSAGES.items():
            stream: Stream | None = getattr(recording, name)
            if stream is None:
                continue
            connection = bag.add_connection(topic, full[kind], typestore=store)
            for time, sample in zip(stream.time, stream.values, strict=True):
                stamp = round(BILLION * float(time))
                header = new("Header", new("Time", *divmod(stamp, BILLION)), name)
                message = new(kind, header, *values_of(new, sample))
                bag.write(connection, max(stamp, 0), store.serialize_cdr(message, full[kind]))


New = Callable[..., Any]
"""Message of a type by its short name, from its values."""


def _joints(_new: New, sample: Array) -> tuple[Any, ...]:
    names = [f"joint_{i}" for i in range(1, len(sample) + 1)]
    return names, np.ascontiguousarray(sample), np.empty(0), np.empty(0)


def _imu(new: New, sample: Array) -> tuple[Any, ...]:
    force, rate = (new("Vector3", *part.tolist()) for part in (sample[:3], sample[3:]))
    turn, unknown = new("Quaternion", 0.0, 0.0, 0.0, 1.0), np.zeros(9)
    return turn, np.r_[-1.0, np.zeros(8)], rate, unknown, force, unknown


def _point(new: New, sample: Array) -> tuple[Any, ...]:
    return (new("Point", *sample.tolist()),)


MESSAGES = {
    "encoders": ("/joint_states", "JointState", _joints),
    "imu": ("/imu", "Imu", _imu),
    "tracker": ("/target", "PointStamped", _point),
}
"""Topic, type and values beside the header, by instrument."""
