"""Bags written with the library that ROS users write them with."""

from types import SimpleNamespace

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_700_000_000
"""[s] First stamp."""


def make(kind, *values):
    """Message of a type, such as geometry_msgs/msg/Point."""
    return STORE.types[kind](*values)


def header(time, frame="map"):
    whole, part = divmod(round(1e9 * time), 10**9)
    stamp = make("builtin_interfaces/msg/Time", whole + START if time >= 0.0 else 0, part)
    return make("std_msgs/msg/Header", stamp, frame)


def vector(kind, values):
    return make(f"geometry_msgs/msg/{kind}", *map(float, values))


def joint_state(time, names, angles):
    names, none = list(names), np.empty(0)
    angles = np.ascontiguousarray(angles, dtype=np.float64)
    return make("sensor_msgs/msg/JointState", header(time), names, angles, none, none)


def imu(time, values, frame="housing", lost=False):
    unknown, none = np.zeros(9), np.r_[-1.0, np.zeros(8)]
    rate, force = vector("Vector3", values[3:]), vector("Vector3", values[:3])
    about = (rate, unknown, force, none if lost else unknown)
    turn = vector("Quaternion", (0, 0, 0, 1))
    return make("sensor_msgs/msg/Imu", header(time, frame), turn, none, *about)


def point(time, values, frame="tracker"):
    return make("geometry_msgs/msg/PointStamped", header(time, frame), vector("Point", values))


def pose(time, values, quaternion, frame="tracker"):
    """Pose with a quaternion, w last."""
    both = vector("Point", values), vector("Quaternion", quaternion)
    own = make("geometry_msgs/msg/Pose", *both)
    return make("geometry_msgs/msg/PoseStamped", header(time, frame), own)


def transform(time, values, child, frame="world"):
    both = vector("Vector3", values), vector("Quaternion", (0, 0, 0, 1))
    moved = make("geometry_msgs/msg/Transform", *both)
    return make("geometry_msgs/msg/TransformStamped", header(time, frame), child, moved)


def write(folder, topics, plugin=StoragePlugin.MCAP):
    """Bag of {topic: [(logged [s], message)]}."""
    with Writer(folder, version=9, storage_plugin=plugin) as bag:
        for topic, messages in topics.items():
            kind = messages[0][1].__msgtype__
            connection = bag.add_connection(topic, kind, typestore=STORE)
            for logged, message in messages:
                raw = STORE.serialize_cdr(message, kind)
                bag.write(connection, round(1e9 * (START + logged)), raw)
    return folder


@pytest.fixture(scope="session")
def ros():
    """Functions that make messages and write bags."""
    own = (joint_state, imu, point, pose, transform, write, make)
    return SimpleNamespace(SQLITE=StoragePlugin.SQLITE3, **{one.__name__: one for one in own})
