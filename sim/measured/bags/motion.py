"""Recording of an arm in motion from a bag."""

from pathlib import Path

import numpy as np

from ...records.files import InputError
from ..motion import MotionRecording, Stream
from ..repair import repaired
from .bag import read_messages
from .messages import BILLION
from .streams import Stamped, encoders, sensor
from .topics import BagTopics


def read(path: Path, topics: BagTopics) -> MotionRecording:
    """Encoders, IMU and one target of a bag; seconds count from the whole one before the first
    stamp of the encoders.

    Raises InputError or ValueError for what is missing, ambiguous or damaged.
    """
    messages = read_messages(path, topics)
    ((topic, angles),) = messages.encoders.items()
    motors, notes = encoders(topic, angles, topics.joints)
    origin = int(motors.stamp[0]) // BILLION * BILLION
    streams: dict[str, Stream] = {}
    streams["encoders"], more = _repaired(topic, motors, origin)
    notes += more
    if len(messages.tracker) > 1:
        raise InputError(f"{path.name}: one target is used here: give one --tracker-topic")
    for name, found in {"imu": messages.imu, "tracker": messages.tracker}.items():
        for topic, own in found.items():
            samples, said = sensor(topic, own)
            if np.isnan(samples.values).all(axis=0).any():
                raise InputError(f"{topic}: the driver marks values that an IMU needs as absent")
            width = 6 if name == "imu" else 3
            samples = samples._replace(values=samples.values[:, :width])
            streams[name], more = _repaired(topic, samples, origin)
            notes += (*(f"{name}: {one}" for one in said), *more)
    return MotionRecording(name=path.stem, form="ROS bag", notes=notes, **streams)


def _repaired(topic: str, samples: Stamped, origin: int) -> tuple[Stream, tuple[str, ...]]:
    return repaired(topic, samples.time(origin), samples.values)
