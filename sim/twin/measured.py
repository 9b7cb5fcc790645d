"""Recorded signals of one cut: what a robot's own sensors and a tool sensor measured.

No ground truth: a twin is identified from nothing else.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.relative_path import REST_SAMPLES, relative_to_start
from ..instruments.imu import ImuSamples
from ..instruments.laser_tracker import TrackerSamples
from ..laser.experiment import Pass
from ..robot.recording import Recording

_TRACKER_FILTER = 40.0
"""[Hz], zero-phase low-pass of tracker positions."""


@dataclass(frozen=True, kw_only=True)
class MeasuredCut:
    """Recorded signals of one run at the log rate."""

    name: str
    reference: Array
    correction: Array
    motor_angle: Array
    """(N, 6) [rad], arm side."""
    motor_torque: Array
    """(N, 6) [N m], motor side."""
    tool: Array | None
    """(N, 3) [m], displacement of the tool from rest in base axes, by a tracker."""
    rest: Array | None = None
    """(3,) [m], position of the tool at rest in base axes, by the tracker."""
    imu: ImuSamples | None = None

    @property
    def moving(self) -> np.ndarray:
        """(N,) bool: the reference moves."""
        still = (np.diff(self.reference, axis=0) == 0.0).all(axis=1)
        return ~np.concatenate((still[:1], still))


def measured(run: Pass, name: str = "cut") -> MeasuredCut:
    """The record of a pass, without its ground truth."""
    return measured_from(run.recording, run.tracker, name, run.imu)


def measured_from(
    log: Recording,
    tracker: TrackerSamples | None,
    name: str,
    imu: ImuSamples | None = None,
) -> MeasuredCut:
    """The record of a run and its instruments, without its ground truth.

    Raises ValueError for a beam that was lost.
    """
    tool, rest = (None, None) if tracker is None else tracked(log.time, tracker, name)
    return MeasuredCut(
        name=name,
        reference=log.reference,
        correction=log.correction,
        motor_angle=log.motor_angle,
        motor_torque=log.motor_torque,
        tool=tool,
        rest=rest,
        imu=imu,
    )


def tracked(time: Array, samples: TrackerSamples, name: str) -> tuple[Array, Array]:
    """Low-passed displacement (N, 3) [m] from rest at the log's instants; position (3,) at rest."""
    if not samples.valid.all():
        lost = int(np.count_nonzero(~samples.valid))
        raise ValueError(f"{name}: the tracker lost {lost} of {len(samples.valid)} samples")
    period = float(samples.time[1] - samples.time[0])
    smooth = ZeroPhaseButterworth(_TRACKER_FILTER, period)(samples.position)
    at = np.clip(np.rint(time / period).astype(int), 0, len(smooth) - 1)
    return relative_to_start(smooth[at])[:, :3], smooth[at][:REST_SAMPLES].mean(axis=0)
