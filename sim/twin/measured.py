"""What a robot's own sensors and a tool sensor recorded of one cut. No ground truth."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.relative_path import relative_to_start
from ..instruments.imu import ImuSamples
from ..instruments.laser_tracker import TrackerSamples
from ..laser.plant import Pass

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
    imu: ImuSamples | None = None

    @property
    def moving(self) -> np.ndarray:
        """(N,) bool: the reference moves."""
        still = (np.diff(self.reference, axis=0) == 0.0).all(axis=1)
        return ~np.concatenate((still[:1], still))


def measured(run: Pass, name: str = "cut") -> MeasuredCut:
    """The record of a pass, without its ground truth."""
    log = run.recording
    return MeasuredCut(
        name=name,
        reference=log.reference,
        correction=log.correction,
        motor_angle=log.motor_angle,
        motor_torque=log.motor_torque,
        tool=tracked(log.time, run.tracker),
        imu=run.imu,
    )


def tracked(time: Array, samples: TrackerSamples) -> Array:
    """Low-passed displacement (N, 3) [m] from rest at the instants of the log."""
    period = float(samples.time[1] - samples.time[0])
    smooth = ZeroPhaseButterworth(_TRACKER_FILTER, period)(samples.position)
    at = np.clip(np.rint(time / period).astype(int), 0, len(smooth) - 1)
    return relative_to_start(smooth[at])[:, :3]
