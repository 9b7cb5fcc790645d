"""Recordings from a bag, by the stamps of the headers: of an arm in motion, or of poses."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from armside.arrays import Array, check_recorded_time
from armside.kinematics.calibration import Measurements
from armside.kinematics.rotation import from_quaternion

from ...records.files import InputError
from ..recorded_motion import MotionRecording, PoseRecording, Stream, repaired
from .messages import BILLION, Joints, Sample, read_messages
from .topics import FRAME, BagTopics

UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
"""Parts of the names of Universal Robots' joints, from the base on; their driver publishes them in
the order of the alphabet."""
NUMBERED = re.compile(r"(.*?)(\d+)(\D*)")


def joint_order(topic: str, names: Sequence[str], asked: Sequence[str]) -> tuple[str, ...]:
    """Names of the joints from the base on.

    Those asked for; or else names that differ in one number alone, by that; or those of Universal
    Robots.

    Raises:
        InputError: a joint is not there, or the names have no order.
    """
    listed = ", ".join(names) or "no names"
    if asked:
        if absent := [name for name in asked if name not in names]:
            raise InputError(f"{topic} has no joint {absent[0]}. Joints: {listed}")
        return tuple(asked)
    if len(set(names)) == len(names) > 0:
        if found := _by_number(names) or _of_ur(names):
            return found
        if len(names) == 1:
            return tuple(names)
    raise InputError(f"the joints of {topic} have no order by name ({listed}): give --joints")


def _by_number(names: Sequence[str]) -> tuple[str, ...]:
    """Names that differ in their last number alone, by that; or none."""
    found = [NUMBERED.fullmatch(name) for name in names]
    parts = [match.groups() for match in found if match]
    around = {(head, tail) for head, _, tail in parts}
    numbers = {int(number): name for (_, number, _), name in zip(parts, names, strict=False)}
    if len(parts) != len(names) or len(around) != 1 or len(numbers) != len(names):
        return ()
    return tuple(numbers[number] for number in sorted(numbers))


def _of_ur(names: Sequence[str]) -> tuple[str, ...]:
    own = [[name for name in names if f"{part}_joint" in name] for part in UR]
    if len(names) != len(UR) or any(len(one) != 1 for one in own):
        return ()
    return tuple(one[0] for one in own)


FEW = 0.5
"""Fraction of the messages that may lack joints before the topic is refused."""


class Stamped(NamedTuple):
    """Samples by the stamps of their headers."""

    stamp: NDArray[np.int64]
    """(N,) [ns]."""
    values: Array
    """(N, m)."""

    def time(self, origin: int) -> Array:
        """(N,) [s] from an origin [ns], exact to the nanosecond for a century."""
        whole, part = np.divmod(self.stamp - origin, BILLION)
        return whole + part / BILLION


def encoders(
    topic: str, messages: list[Joints], asked: tuple[str, ...]
) -> tuple[Stamped, tuple[str, ...]]:
    """Angles in the order of the motors, and notes: order of the joints, messages left out.

    Raises InputError for joints without an order, and messages without angles or stamps.
    """
    names = tuple(dict.fromkeys(name for one in messages for name in one.names))
    order = joint_order(topic, names, asked)
    rows, stamps = [], []
    places: dict[tuple[str, ...], list[int] | None] = {}
    for one in messages:
        if one.names not in places:
            whole = set(order) <= set(one.names)
            places[one.names] = [one.names.index(name) for name in order] if whole else None
        place = places[one.names]
        if place is not None and len(one.position) == len(one.names):
            rows.append(one.position[place])
            stamps.append(one.stamp)
    if len(rows) <= FEW * len(messages):
        text = f"{len(messages) - len(rows)} of {len(messages)} messages lack positions of some of"
        raise InputError(f"{topic}: {text} {', '.join(order)}: choose others by --joints")
    notes = [f"encoders: {topic}, joints {', '.join(order)}"]
    if left := len(messages) - len(rows):
        notes.append(f"encoders: {left} messages without all of these joints are left out")
    return _stamped(topic, stamps, np.array(rows)), tuple(notes)


def sensor(topic: str, found: list[Sample]) -> tuple[Stamped, tuple[str, ...]]:
    """Samples of an IMU or a target, and a note of its frames.

    Raises InputError for samples of several frames, or without stamps.
    """
    children = sorted({one.child for one in found})
    if len(children) > 1:
        text = f"measures {len(children)} frames: {', '.join(children)}"
        raise InputError(f"{topic} {text}; choose one as {topic}{FRAME}{children[0]}")
    frames = sorted({one.frame for one in found})
    if len(frames) > 1:
        raise InputError(f"{topic} gives its values in {len(frames)} frames: {', '.join(frames)}")
    values = np.array([one.values for one in found], dtype=np.float64)
    said = f"{topic}, frame {frames[0] or 'without a name'}"
    return _stamped(topic, [one.stamp for one in found], values), (said,)


def _stamped(topic: str, stamps: list[int], values: Array) -> Stamped:
    if not any(stamps):
        raise InputError(f"{topic}: the headers carry no stamps (all are zero)")
    return Stamped(np.array(stamps, dtype=np.int64), values)


def motion_of_bag(path: Path, topics: BagTopics) -> MotionRecording:
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


WINDOW = 0.2
"""[s] About an instant, in which the arm must not move. ESTIMATE: vibration has died away."""
STILL = 3e-4
"""[rad or m] Motion of a motor within the window that is none. ESTIMATE: counts of an encoder."""
LARGEST_GAP = 1.0
"""[s] Between samples of the encoders, across which the arm is not known to stand still."""


def poses_of_bag(path: Path, topics: BagTopics) -> PoseRecording:
    """One configuration for each stand of the arm that a target was seen in.

    Stamps of encoders and tracker are taken to be of one clock, as ROS has it. While the arm stands
    still an offset between them changes nothing.

    Raises InputError for what is missing, ambiguous or damaged, and where there is no such stand.
    """
    messages = read_messages(path, topics)
    ((topic, angles),) = messages.encoders.items()
    motors, notes = encoders(topic, angles, topics.joints)
    if not messages.tracker:
        raise InputError(f"{path.name} has no target of a tracker: poses need one")
    _check_clock(topic, motors)
    origin = int(motors.stamp[0]) // BILLION * BILLION
    time = motors.time(origin)
    stand = _stands(time, motors.values)
    targets = []
    for name, found in messages.tracker.items():
        samples, said = sensor(name, found)
        notes += tuple(f"tracker: {one}" for one in said)
        targets.append(_by_stand(samples, samples.time(origin), time, stand))
    seen = sorted(set().union(*targets))
    if not seen:
        text = "no target was seen while the arm stood still"
        raise InputError(f"{path.name}: {text} for {WINDOW:g} s: is it a recording of poses?")
    notes += (f"{len(seen)} poses at which the arm stood still and a target was seen",)
    return PoseRecording(_measurements(motors.values, stand, seen, targets), "ROS bag", notes)


def _check_clock(topic: str, motors: Stamped) -> None:
    if not np.isfinite(motors.values).all():
        raise InputError(f"{topic}: a position is not finite")
    check_recorded_time(topic, motors.time(int(motors.stamp[0])), gap=np.inf, repeats=True)


def _stands(time: Array, phi: Array) -> NDArray[np.intp]:
    """Number of the stand of each sample (N,), from 1; 0 in motion."""
    step = float(np.median(np.diff(time))) if len(time) > 1 else WINDOW
    width = 2 * max(1, round(0.5 * WINDOW / max(step, 1e-6))) + 1
    moved = maximum_filter1d(phi, width, axis=0) - minimum_filter1d(phi, width, axis=0)
    still: NDArray[np.bool_] = np.all(moved < STILL, axis=1)
    goes_on = np.zeros(len(time), dtype=bool)
    goes_on[1:] = still[:-1] & (np.diff(time) < LARGEST_GAP)
    starts = still & ~goes_on
    return np.where(still, np.cumsum(starts), 0)


def _by_stand(
    samples: Stamped, at: Array, time: Array, stand: NDArray[np.intp]
) -> dict[int, Array]:
    """Median of a target's samples (m,) in each stand that it was seen in."""
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    same = stand[after] * (stand[after] == stand[after - 1])
    inside = (at >= time[0]) & (at <= time[-1]) & np.isfinite(samples.values).all(axis=1)
    found = _grouped(np.where(inside, same, 0), samples.values)
    return {k: _middle(own) for k, own in found.items()}


def _grouped(number: NDArray[np.intp], values: Array) -> dict[int, Array]:
    """Rows of each number that is not zero."""
    order = np.argsort(number, kind="stable")
    numbers, starts = np.unique(number[order], return_index=True)
    parts = np.split(values[order], starts[1:])
    return {int(k): own for k, own in zip(numbers, parts, strict=True) if k}


def _middle(values: Array) -> Array:
    """Median of samples (N, 3), or (N, 7) with quaternions, whose sign has no meaning."""
    turns = values[:, 3:]
    signs = np.where(turns @ turns[0] < 0.0, -1.0, 1.0)
    return np.median(np.hstack((values[:, :3], turns * signs[:, None])), axis=0)


def _measurements(
    phi: Array, stand: NDArray[np.intp], seen: list[int], targets: list[dict[int, Array]]
) -> Measurements:
    absent = np.full(3, np.nan)
    points = [[own[k][:3] if k in own else absent for own in targets] for k in seen]
    angles = _grouped(stand, phi)
    at = np.array([np.median(angles[k], axis=0) for k in seen])
    return Measurements(phi=at, points=np.array(points), rotation=_rotation(seen, targets[0]))


def _rotation(seen: list[int], target: dict[int, Array]) -> Array | None:
    """(N, 3, 3), where the first target has an orientation that is one, in every pose."""
    if any(k not in target or len(target[k]) < 7 for k in seen):
        return None
    turns = np.array([target[k][3:7] for k in seen])
    length = np.linalg.norm(turns, axis=1)
    if np.abs(length - 1.0).max() > 0.01 or np.ptp(turns, axis=0).max() == 0.0:
        return None
    return from_quaternion(turns / length[:, None])
