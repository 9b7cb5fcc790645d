"""Recordings of a virtual robot in the motion that its gears are found from.

The individual, its IMU and its tracker are those that `armside laser` draws with the same seed.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits, compile

from ..cell import Cell, ToolPose
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..laser.experiment import prepare
from ..laser.specification import Setup
from ..motion.tool_motion import joint_reference
from ..recordings.recorded_motion import MotionRecording, Stream
from ..robot.virtual_robot import LOG_PERIOD

SINES = 3
"""In the motion of each motor."""
OF_SLIDE = 0.1
"""Motion of a slide [m] for each radian of other motors. ESTIMATE: strokes are 0.2 m and more."""
SMALLEST = 0.3
"""Fraction of the motion that must have room."""


DURATION = 120.0
"""[s], of a motion."""
FREQUENCY, AMPLITUDE = (0.015, 0.05), (0.13, 0.26)
"""[Hz] and [rad], range of each sine, another for each motor."""
RAMP = 3.0
"""[s], from rest and to rest."""


def excitation(
    centre: Array, limits: Limits, rng: np.random.Generator, slides: Sequence[bool]
) -> Array:
    """Motor angles (N, n) [rad] at the log rate around `centre` (n,): sums of sines, in [m] of
    `slides`, made smaller where a joint limit is near. Raises ValueError where hardly any motion is
    left; names the axis."""
    time = np.arange(0.0, DURATION, LOG_PERIOD)
    motion = np.zeros((len(time), len(centre)))
    for joint in range(len(centre)):
        for _ in range(SINES):
            f, a = rng.uniform(*FREQUENCY), rng.uniform(*AMPLITUDE)
            phase = rng.uniform(0.0, 2.0 * np.pi)
            motion[:, joint] += a * np.sin(2.0 * np.pi * f * time + phase)
    ramp = np.clip(time / RAMP, 0.0, 1.0)
    ramp = ramp**2 * (3.0 - 2.0 * ramp)
    motion *= (ramp * ramp[::-1])[:, None]
    motion[:, np.array(slides)] *= OF_SLIDE
    for size in np.arange(1.0, SMALLEST - 0.05, -0.05):
        if limits.contain(centre + size * motion).all():
            return centre + size * motion
    said = _nearest(centre, SMALLEST * motion, limits)
    raise ValueError(f"{said} too near to a joint limit for a motion that excites gears")


def _nearest(centre: Array, motion: Array, limits: Limits) -> str:
    """The axis that leaves its range farthest, over its range; the pose where only sums do."""
    over = np.maximum(
        (centre + motion - limits.upper).max(axis=0), (limits.lower - centre - motion).max(axis=0)
    )
    over /= np.subtract(limits.upper, limits.lower)
    worst = int(over.argmax())
    return f"axis {worst + 1} of the pose is" if over[worst] > 0.0 else "the pose is"


RUNS = 6
"""Of a robot whose gears are to be found."""
REFLECTOR = LaserTrackerCfg(acceptance_angle=np.pi)
"""Tracker on a motorised reflector that turns towards it (API Active Target): a corner cube loses
the beam while the wrist turns."""
_PARALLEL = 1e-6  # second singular value of the axes' directions, of axes that are parallel
_MOTION, _TRACKING = 0x6EA2, 0x6EA3  # streams, apart from those of individual and instruments


class _At(NamedTuple):
    position: Array
    quaternion: Array


def posture(cell: Cell, pose: ToolPose) -> Array:
    """Motor angles (n,) [rad] at a pose. Raises ValueError for a pose out of reach."""
    at = _At(np.array([pose.position]), np.array([pose.quaternion]))
    free = cell.free_rotation
    return joint_reference(at, cell.robot, cell.limits, start=cell.home, free_rotation=free)[0]


def recorded(setup: Setup, seed: int, repetition: int = 0) -> MotionRecording:
    """One run of an individual; each repetition is another motion with other noise.

    Raises ValueError for a pose that cannot be reached or excited, a payload that is too heavy, or
    an arm that turns its tool about one direction alone.
    """
    cell = setup.cell
    centre = posture(cell, setup.tool_pose)
    rotation = compile(cell.robot).jacobian(centre)[3:]
    if np.linalg.matrix_rank(rotation, tol=_PARALLEL) < 2:  # the IMU's mounting cannot be found
        said = f"the axes of {cell.robot.name} turn the tool about one direction alone"
        raise ValueError(f"{said}: gears needs two, to find how the IMU is mounted")
    moving, tracking = (np.random.default_rng([seed, repetition, k]) for k in (_MOTION, _TRACKING))
    reference = excitation(centre, cell.limits, moving, cell.robot.slides)
    made = prepare(setup, planned=lambda _: (None, reference), seed=seed, repetition=repetition)
    plant = replace(made.plant, tracker=set_up(REFLECTOR, tracking))
    run = plant.run(np.zeros_like(reference))
    imu, seen = None, run.tracker.valid
    if run.imu is not None:
        values = np.hstack((run.imu.acceleration, run.imu.angular_velocity))
        known = np.isfinite(values).all(axis=1)
        imu = Stream(run.imu.time[known], values[known])
    return MotionRecording(
        name=f"run {repetition + 1}",
        encoders=Stream(run.recording.time, run.recording.motor_angle),
        imu=imu,
        tracker=Stream(run.tracker.time[seen], run.tracker.position[seen]),
        form="virtual robot",
    )
