"""Recordings from a bag, by the stamps of the headers: of an arm in motion, or of poses."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from armside.arrays import Array, check_recorded_time
from armside.kinematics.calibration import Measurements
from armside.kinematics.rotation import from_quaternion

from ...records.files import InputError
from ..recorded_motion import MotionRecording, PoseRecording, Stream, repaired
from .messages import BILLION, FRAME, BagTopics, Joints, Sample, read_messages

UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
"""Parts of the names of Universal Robots' joints, from the base on; their driver publishes them in
the order of the alphabet."""
NUMBERED = re.compile(r"(.*?)(\d+)(\D*)")


def joint_order(topic: str, names: Sequence[str], asked: Sequence[str]) -> tuple[str, ...]:
    """Names of the joints from the base on.

    Those asked for; or names that differ in one number alone, by that; or those of Universal
    Robots. Raises InputError for a joint that is not there, or names without an order.
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


def encoders(
    topic: str, messages: list[Joints], asked: tuple[str, ...]
) -> tuple[int, Stream, tuple[str, ...]]:
    """Whole second [ns] before the first stamp, from which all times count; angles in the order of
    the motors; notes: order of the joints, messages left out."""
    listed = {one.names: set(one.names) for one in messages}
    order = joint_order(topic, tuple(dict.fromkeys(name for own in listed for name in own)), asked)
    places = {o: [o.index(name) for name in order] for o, own in listed.items() if own >= {*order}}
    whole = [one for one in messages if one.names in places and len(one.position) == len(one.names)]
    left, joints = len(messages) - len(whole), ", ".join(order)
    if len(whole) <= FEW * len(messages):
        text = f"{left} of {len(messages)} messages lack positions of some of {joints}"
        raise InputError(f"{topic}: {text}: choose others by --joints")
    notes = [f"encoders: {topic}, joints {joints}"]
    if left:
        notes.append(f"encoders: {left} messages without all of these joints are left out")
    rows = np.array([one.position[places[one.names]] for one in whole])
    origin = whole[0].stamp // BILLION * BILLION
    return origin, Stream(_seconds(topic, whole, origin), rows), tuple(notes)


def sensor(topic: str, found: list[Sample], origin: int) -> tuple[Stream, str]:
    """Samples of an IMU or a target, in one frame, and a note of it."""
    children = sorted({one.child for one in found})
    if len(children) > 1:
        text = f"measures {len(children)} frames: {', '.join(children)}"
        raise InputError(f"{topic} {text}; choose one as {topic}{FRAME}{children[0]}")
    frames = sorted({one.frame for one in found})
    if len(frames) > 1:
        raise InputError(f"{topic} gives its values in {len(frames)} frames: {', '.join(frames)}")
    values = np.array([one.values for one in found], dtype=np.float64)
    said = f"{topic}, frame {frames[0] or 'without a name'}"
    return Stream(_seconds(topic, found, origin), values), said


def _seconds(topic: str, found: Sequence[Joints | Sample], origin: int) -> Array:
    """Stamps (N,) [s] from an origin [ns], exact to the nanosecond for a century."""
    stamps = np.array([one.stamp for one in found], dtype=np.int64)
    if not stamps.any():
        raise InputError(f"{topic}: the headers carry no stamps (all are zero)")
    whole, part = np.divmod(stamps - origin, BILLION)
    return whole + part / BILLION


def motion_of_bag(path: Path, topics: BagTopics) -> MotionRecording:
    """Encoders, IMU and one target of a bag; seconds from the whole one before the first stamp."""
    messages = read_messages(path, topics)
    ((topic, angles),) = messages.encoders.items()
    origin, motors, notes = encoders(topic, angles, topics.joints)
    encoder, more = repaired(topic, motors.time, motors.values)
    notes, streams = notes + more, {"encoders": encoder}
    if len(messages.tracker) > 1:
        raise InputError(f"{path.name}: one target is used here: give one --tracker-topic")
    for name, found in {"imu": messages.imu, "tracker": messages.tracker}.items():
        for topic, own in found.items():
            samples, said = sensor(topic, own, origin)
            if np.isnan(samples.values).all(axis=0).any():
                raise InputError(f"{topic}: the driver marks values that an IMU needs as absent")
            values = samples.values[:, : 6 if name == "imu" else 3]
            streams[name], more = repaired(topic, samples.time, values)
            notes += (f"{name}: {said}", *more)
    return MotionRecording(name=path.stem, form="ROS bag", notes=notes, **streams)


WINDOW = 0.2
"""[s] About an instant, in which the arm must not move. ESTIMATE: vibration has died away."""
STILL = 3e-4
"""[rad or m] Motion of a motor within the window that is none. ESTIMATE: counts of an encoder."""
LARGEST_GAP = 1.0
"""[s] Between samples of the encoders, across which the arm is not known to stand still."""


def poses_of_bag(path: Path, topics: BagTopics) -> PoseRecording:
    """One configuration for each stand of the arm that a target was seen in.

    Stamps of encoders and tracker are taken to be of one clock, as ROS has it: an offset changes
    nothing while the arm stands still. Raises InputError for what is missing, ambiguous or damaged,
    and for a bag without a stand.
    """
    messages = read_messages(path, topics)
    ((topic, angles),) = messages.encoders.items()
    origin, motors, notes = encoders(topic, angles, topics.joints)
    if not messages.tracker:
        raise InputError(f"{path.name} has no target of a tracker: poses need one")
    if not np.isfinite(motors.values).all():
        raise InputError(f"{topic}: a position is not finite")
    check_recorded_time(topic, motors.time - motors.time[0], gap=np.inf, repeats=True)
    stand = _stands(motors.time, motors.values)
    targets = []
    for name, found in messages.tracker.items():
        samples, said = sensor(name, found, origin)
        notes += (f"tracker: {said}",)
        targets.append(_by_stand(samples, motors.time, stand))
    seen = sorted(set().union(*targets))
    if not seen:
        text = "no target was seen while the arm stood still"
        raise InputError(f"{path.name}: {text} for {WINDOW:g} s: is it a recording of poses?")
    notes += (f"{len(seen)} poses at which the arm stood still and a target was seen",)
    angles, absent = _grouped(stand, motors.values), np.full(3, np.nan)
    measurements = Measurements(
        phi=np.array([np.median(angles[k], axis=0) for k in seen]),
        points=np.array([[own[k][:3] if k in own else absent for own in targets] for k in seen]),
        rotation=_rotation(seen, targets[0]),
    )
    return PoseRecording(measurements, "ROS bag", notes)


def _stands(time: Array, phi: Array) -> NDArray[np.intp]:
    """Number of the stand of each sample (N,), from 1; 0 in motion."""
    step = float(np.median(np.diff(time))) if len(time) > 1 else WINDOW
    width = 2 * max(1, round(0.5 * WINDOW / max(step, 1e-6))) + 1
    moved = maximum_filter1d(phi, width, axis=0) - minimum_filter1d(phi, width, axis=0)
    still: NDArray[np.bool_] = np.all(moved < STILL, axis=1)
    goes_on = np.r_[False, still[:-1] & (np.diff(time) < LARGEST_GAP)]
    return np.where(still, np.cumsum(still & ~goes_on), 0)


def _by_stand(samples: Stream, time: Array, stand: NDArray[np.intp]) -> dict[int, Array]:
    """Median of a target's samples (m,) in each stand that it was seen in."""
    at = samples.time
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


def _rotation(seen: list[int], target: dict[int, Array]) -> Array | None:
    """(N, 3, 3), where the first target has an orientation that is one, in every pose."""
    if any(k not in target or len(target[k]) < 7 for k in seen):
        return None
    turns = np.array([target[k][3:7] for k in seen])
    length = np.linalg.norm(turns, axis=1)
    if np.abs(length - 1.0).max() > 0.01 or np.ptp(turns, axis=0).max() == 0.0:
        return None
    return from_quaternion(turns / length[:, None])
