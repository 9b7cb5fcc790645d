"""One recording with its clocks, sensors and frames aligned with the encoders."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array
from armside.kinematics import CompiledRobot

from ..recordings.alignment.checks import check_motors
from ..recordings.alignment.encoder_motion import RATE, EncoderMotion, encoder_motion
from ..recordings.alignment.imu_alignment import ImuAlignment, align_imu
from ..recordings.alignment.tracker import TrackerAlignment, align_tracker
from ..recordings.recorded_motion import MotionRecording
from .residual_spectra import Observation

Sensor = Literal["imu", "tracker"]
EDGE = 1.5
"""[s] At both ends, where filters have not settled."""
SAMPLES = 3.0
"""Sampling rate of an observation over the end of its band, at least."""
SHORTEST_SEEN = 5.0
"""[s] Of a recording that can be analysed."""
ALIGNED_ON = 0.5
"""Fraction of a recording, from its start, that clock, base and tool of a tracker come from."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Aligned:
    """A recording, its motion by the encoders, and the constants of its sensors."""

    recording: MotionRecording
    motion: EncoderMotion
    imu: ImuAlignment | None
    tracker: TrackerAlignment | None

    @property
    def name(self) -> str:
        """Name of the recording."""
        return self.recording.name

    @property
    def target(self) -> Array:
        """(3,) [m], point of the tool frame whose error is stated: the tracker's, or the IMU's."""
        if self.tracker is not None:
            return self.tracker.target
        return np.zeros(3) if self.imu is None else self.imu.lever

    def clock(self, sensor: Sensor) -> Array:
        """(M,) [s], times of a sensor's clock at the samples of the motion."""
        if sensor == "imu":
            assert self.imu is not None
            return self.imu.clock(self.motion, self.imu.accelerometer_delay)
        assert self.tracker is not None
        return self.tracker.clock(self.motion)

    def observation(
        self, sensor: Sensor, band: tuple[float, float], part: tuple[float, float] = (0.0, 1.0)
    ) -> Observation:
        """Residual of a sensor in a part of the recording, as fractions of its length."""
        motion = self.motion
        if sensor == "imu":
            assert self.imu is not None
            assert self.recording.imu is not None
            point = self.imu.lever
            residual = self.imu.residual(motion, self.recording.imu)
            seen = self.imu.covered(motion, self.recording.imu)
        else:
            assert self.tracker is not None
            point = self.tracker.target
            residual, seen = self.tool_residual()
        stride = max(1, int(RATE / (SAMPLES * band[1])))
        first, last = _stretch(seen, part)
        rows = slice(first, last, stride)
        return Observation(
            phi=motion.phi[rows],
            rate=motion.rate[rows],
            J_point=motion.point_jacobian(point)[rows],
            J_rotation=motion.J[rows, 3:],
            residual=_thinned(residual[first:last], stride),
            band=band,
            sampling=RATE / stride,
        )

    def tool_residual(self) -> tuple[Array, NDArray[np.bool_]]:
        """(M, 3) [m], tracker less encoders in base axes, and the samples that it saw."""
        assert self.tracker is not None
        assert self.recording.tracker is not None
        seen = self.tracker.covered(self.motion, self.recording.tracker)
        return self.tracker.residual(self.motion, self.recording.tracker), seen


def _stretch(seen: NDArray[np.bool_], part: tuple[float, float]) -> tuple[int, int]:
    """Samples from the first to the last that were seen, without the edges, of a part."""
    where, edge = np.flatnonzero(seen), int(EDGE * RATE)
    length = (where[-1] - where[0] if len(where) else 0) - 2 * edge
    if length < SHORTEST_SEEN * RATE:
        raise ValueError(f"{max(length, 0) / RATE:.3g} s were seen by the sensor and the encoders")
    first = int(where[0]) + edge
    return first + int(part[0] * length), first + int(part[1] * length)


def _thinned(x: Array, stride: int) -> Array:
    """Every `stride`-th sample after a sharp low-pass."""
    from scipy.signal import butter, sosfiltfilt

    if stride == 1:
        return x
    return sosfiltfilt(butter(8, 0.88 / stride, output="sos"), x, axis=0)[::stride]


def align(robot: CompiledRobot, recording: MotionRecording) -> Aligned:
    """Alignment of every sensor of a recording.

    Raises:
        ValueError: a sensor did not see this motion, or its units are wrong; names the recording.
    """
    imu, tracker = None, None
    try:
        motion = encoder_motion(robot, recording.encoders)
        if recording.imu is not None:
            check_motors(robot, motion, recording.imu)
            imu = align_imu(motion, recording.imu)
        if recording.tracker is not None:
            tracker = align_tracker(motion, recording.tracker, ALIGNED_ON)
    except ValueError as error:
        raise ValueError(f"{recording.name}: {error}") from error
    return Aligned(recording=recording, motion=motion, imu=imu, tracker=tracker)
