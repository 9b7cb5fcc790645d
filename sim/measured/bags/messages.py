"""Numbers of ROS messages: joint angles, IMU samples, points with orientation.

Units are those of ROS (REP 103): rad, m, m/s^2, rad/s; quaternions there have w last.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from armside.arrays import Array

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


def joints(message: Any) -> Joints:
    """Angles of a sensor_msgs/JointState."""
    position = np.asarray(message.position, dtype=np.float64)
    return Joints(_stamp(message.header), tuple(message.name), position)


def samples(kind: str, message: Any) -> Iterator[Sample]:
    """Samples of a message of another type: one, or of TFMessage one for each frame."""
    match kind.rpartition("/")[2]:
        case "Imu":
            yield _sample(message.header, "", _imu(message))
        case "PoseStamped":
            pose = message.pose
            yield _sample(message.header, "", _vector(pose.position) + _turn(pose.orientation))
        case "PointStamped":
            yield _sample(message.header, "", _vector(message.point))
        case "TransformStamped":
            yield _transform(message)
        case "TFMessage":
            yield from (_transform(one) for one in message.transforms)


def _transform(message: Any) -> Sample:
    moved = message.transform
    values = _vector(moved.translation) + _turn(moved.rotation)
    return _sample(message.header, message.child_frame_id, values)


def _imu(message: Any) -> tuple[float, ...]:
    """Specific force and angular rate; NaN where the driver says by -1 that it has none."""
    values: tuple[float, ...] = ()
    for name in ("linear_acceleration", "angular_velocity"):
        absent = getattr(message, f"{name}_covariance")[0] == -1.0
        values += (np.nan,) * 3 if absent else _vector(getattr(message, name))
    return values


def _sample(header: Any, child: str, values: tuple[float, ...]) -> Sample:
    return Sample(_stamp(header), header.frame_id, child, values)


def _stamp(header: Any) -> int:
    return BILLION * int(header.stamp.sec) + int(header.stamp.nanosec)


def _vector(v: Any) -> tuple[float, ...]:
    return (v.x, v.y, v.z)


def _turn(q: Any) -> tuple[float, ...]:
    return (q.w, q.x, q.y, q.z)
