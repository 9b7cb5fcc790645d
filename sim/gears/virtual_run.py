"""Recordings of a virtual robot in the motion that its gears are found from.

The individual, its IMU and its tracker are those that `armside laser` draws with the same seed.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from armside.arrays import Array
from armside.kinematics import Robot, compile

from ..cell import Cell, ToolPose
from ..cut.tool_motion import joint_reference
from ..instruments.laser_tracker import LaserTrackerCfg, set_up
from ..laser.experiment import Pass, prepare
from ..laser.specification import Setup
from ..measured.motion import MotionRecording, Stream
from .excitation import Excitation

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


def recorded(
    setup: Setup, seed: int, repetition: int = 0, excitation: Excitation = Excitation()
) -> MotionRecording:
    """One run of an individual; each repetition is another motion with other noise.

    Raises ValueError for a pose that cannot be reached or excited, a payload that is too heavy, or
    an arm that turns its tool about one direction alone.
    """
    cell = setup.cell
    centre = posture(cell, setup.tool_pose)
    _check_turns(cell.robot, centre)
    moving, tracking = (np.random.default_rng([seed, repetition, k]) for k in (_MOTION, _TRACKING))
    reference = excitation.reference(centre, cell.limits, moving, cell.robot.slides)
    made = prepare(setup, planned=lambda _: (None, reference), seed=seed, repetition=repetition)
    plant = replace(made.plant, tracker=set_up(REFLECTOR, tracking))
    return _recording(plant.run(np.zeros_like(reference)), f"run {repetition + 1}")


def _check_turns(robot: Robot, centre: Array) -> None:
    """Raise ValueError where the gyro sees one direction: the IMU's mounting cannot be found."""
    rotation = compile(robot).jacobian(centre)[3:]
    if np.linalg.matrix_rank(rotation, tol=_PARALLEL) < 2:
        said = f"the axes of {robot.name} turn the tool about one direction alone"
        raise ValueError(f"{said}: gears needs two, to find how the IMU is mounted")


def _recording(run: Pass, name: str) -> MotionRecording:
    imu, seen = None, run.tracker.valid
    if run.imu is not None:
        values = np.hstack((run.imu.acceleration, run.imu.angular_velocity))
        known = np.isfinite(values).all(axis=1)
        imu = Stream(run.imu.time[known], values[known])
    return MotionRecording(
        name=name,
        encoders=Stream(run.recording.time, run.recording.motor_angle),
        imu=imu,
        tracker=Stream(run.tracker.time[seen], run.tracker.position[seen]),
        form="virtual robot",
    )
