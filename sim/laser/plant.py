"""Cutting with a virtual robot: planned motion, reference, and the plant of the learning loop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from ..cell import Cell
from ..instruments.imu import Imu, ImuSamples
from ..instruments.laser_tracker import LaserTracker, TrackerSamples
from ..motion.contour import ArcsAndLines
from ..motion.path import CuttingPath
from ..motion.timing import PathLimits
from ..motion.tool_motion import ToolMotion, joint_reference, plan_cut
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.statics import Statics, anticipated_shift, smoothed
from ..robot.virtual_robot import LOG_PERIOD


def plan(
    cell: Cell,
    nominal: Statics,
    path: CuttingPath,
    quaternion: ArrayLike,
    speed: float,
    path_limits: PathLimits | None = None,
) -> tuple[ToolMotion, Array]:
    """A cut at `speed` [m/s] and its reference r, shape (N, n) [rad], as the controller makes it.

    Inverse kinematics of the programmed path; then again of the path shifted against the elastic
    deflection that the controller anticipates.

    Raises:
        ValueError: the motion leaves the joint limits (where) or the reach (by how much).
    """
    motion, phi = plan_cut(
        path,
        quaternion,
        speed,
        cell.robot,
        cell.limits,
        start=cell.home,
        path_limits=path_limits,
        step=LOG_PERIOD,
        free_rotation=cell.free_rotation,
    )
    shift = anticipated_shift(nominal, phi, LOG_PERIOD)
    if isinstance(path.curve, ArcsAndLines):
        shift = smoothed(shift)
    free = cell.free_rotation
    return motion, joint_reference(
        motion, cell.robot, cell.limits, start=phi[0], shift=shift, free_rotation=free
    )


@dataclass(frozen=True, kw_only=True)
class Pass:
    """One pass over the contour: recorded signals and samples of the instruments."""

    recording: Recording
    tracker: TrackerSamples
    imu: ImuSamples | None = None


@dataclass(frozen=True)
class MountedImu:
    """A unit at the tool, with noise of its own."""

    unit: Imu
    rng: np.random.Generator

    def read(self, recording: Recording) -> ImuSamples:
        """Samples of a run."""
        truth = recording.truth
        return self.unit.measure(
            truth.time, truth.imu_acceleration, truth.imu_angular_velocity, self.rng
        )


@dataclass(frozen=True)
class CuttingPlant:
    """Plant of a learning loop: a loaded reference under a laser tracker, with an IMU if wanted."""

    loaded: LoadedReference
    tracker: LaserTracker
    rng: np.random.Generator
    """Source of torque and tracker noise."""
    imu: MountedImu | None = None

    def run(self, correction: Array, /) -> Pass:
        """Cut once with a correction."""
        recording = self.loaded.run(correction, self.rng)
        truth = recording.truth
        samples = self.tracker.measure(
            truth.time, truth.tool_position, truth.tool_quaternion, self.rng
        )
        imu = None if self.imu is None else self.imu.read(recording)
        return Pass(recording=recording, tracker=samples, imu=imu)
