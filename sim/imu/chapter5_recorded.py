"""Thesis chapter 5 on the recording of a real robot with an IMU at its tool.

Constants of the IMU are fitted on the first half of a recording, and what they leave is judged on
the second. Those that are compared between recordings are fitted on the whole.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armside.arrays import Array
from armside.kinematics import Arm, compile

from ..recordings.alignment.checks import check_motors
from ..recordings.alignment.encoder_motion import RATE, EncoderMotion, encoder_motion, lowpass
from ..recordings.alignment.imu_alignment import ImuAlignment, align_imu
from ..recordings.alignment.tracker import TrackerAlignment, align_tracker
from ..recordings.recorded_motion import MotionRecording, Stream, check_angles, check_times
from .measured_beside_predicted import ImuComparison, moving_rms
from .phases import WINDOW, rms

FITTED = 0.5
"""Fraction of a recording, from its start, that is fitted before the rest is judged."""
EDGE = 1.5
"""[s] At both ends of what is judged, where filters have not settled."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictionErrors:
    """Error of the prediction beside its signal; vectors are x, y, z in base axes."""

    angular_velocity: Array
    angular_velocity_error: Array
    """(3,) RMS [rad/s]: predicted motion, and measured less predicted. Thesis Fig. 5.8."""
    acceleration: Array
    acceleration_error: Array
    """(3,) RMS [m/s^2], without gravity. Thesis Fig. 5.9."""
    gravity: Array
    """(3,) [m/s^2], mean of the gravity that the accelerometer sees, base axes."""
    gravity_angle: float
    gravity_angle_rms: float
    """[rad], between that mean, or each of its samples, and the gravity that was fitted."""

    @property
    def gravity_magnitude(self) -> float:
        """Norm of the mean gravity [m/s^2]; 9.81 was fitted."""
        return float(np.linalg.norm(self.gravity))


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedImu:
    """Processing of one recording."""

    recording: MotionRecording
    motion: EncoderMotion
    alignment: ImuAlignment
    """Of the whole recording."""
    tracker: TrackerAlignment | None
    """Of the first half."""
    comparison: ImuComparison
    """Of the second half, by the constants of the first."""
    measures: PredictionErrors

    @property
    def name(self) -> str:
        """Name of the recording."""
        return self.recording.name

    @property
    def window_rms(self) -> Array:
        """(K, 3) [m/s^2], moving RMS of the acceleration error. Thesis Fig. 5.10."""
        return moving_rms(self.comparison.acceleration_error, WINDOW, 1.0 / RATE)

    def tool(self) -> tuple[Array, Array, Array] | None:
        """Time (K,) [s], tool by the tracker and by the encoders (K, 3) [m]; None without tracker.

        Second half, base axes. Thesis Fig. 5.7.
        """
        if self.tracker is None or self.recording.tracker is None:
            return None
        rows = _rows(self.tracker.covered(self.motion, self.recording.tracker))
        by_encoders = self.motion.T[:, :3, 3] + self.motion.lever(self.tracker.target)
        seen = by_encoders + self.tracker.residual(self.motion, self.recording.tracker)
        return self.motion.time[rows], seen[rows], by_encoders[rows]


def process(arm: Arm, recording: MotionRecording, cutoff: float = 5.0) -> RecordedImu:
    """Align, predict and compare one recording.

    cutoff: [Hz], zero-phase low-pass of both sides. Thesis 5.1.1.

    Raises:
        ValueError: no IMU, units or angles that cannot be right, or another motion; names the
            recording.
    """
    check_angles(arm.limits, recording)
    check_times(recording)
    imu, tracker = recording.imu, None
    if imu is None:
        raise ValueError(f"{recording.name}: the recording has no IMU")
    try:
        motion = encoder_motion(robot := compile(arm.robot), recording.encoders)
        check_motors(robot, motion, imu)
        whole = align_imu(motion, imu, level=False)
        seen = whole.covered(motion, imu)
        if (part := float(seen[: int(FITTED * len(seen))].mean())) < 0.5:
            text = f"the IMU saw {100 * part:.0f} % of the first half of what the encoders saw"
            raise ValueError(f"{text}: cut both to the same time")
        half = align_imu(motion, imu, FITTED, level=False)
        if recording.tracker is not None:
            tracker = align_tracker(motion, recording.tracker, FITTED)
        comparison = _compared(motion, imu, half, cutoff)
    except ValueError as error:
        raise ValueError(f"{recording.name}: {error}") from error
    return RecordedImu(
        recording=recording,
        motion=motion,
        alignment=whole,
        tracker=tracker,
        comparison=comparison,
        measures=_measures(comparison, half.gravity),
    )


def _compared(
    motion: EncoderMotion, imu: Stream, half: ImuAlignment, cutoff: float
) -> ImuComparison:
    rows = _rows(half.covered(motion, imu))
    both = half.measured(motion, imu), half.predicted(motion)
    measured, predicted = (lowpass(x, cutoff)[rows] for x in both)
    return ImuComparison(
        time=motion.time[rows],
        angular_velocity_measured=measured[:, 3:],
        angular_velocity_predicted=predicted[:, 3:],
        acceleration_measured=measured[:, :3] + half.gravity,
        acceleration_predicted=predicted[:, :3] + half.gravity,
        clock_offset=-half.gyro_delay,
    )


def _rows(seen: NDArray[np.bool_]) -> slice:
    """Samples that the IMU saw after the part that was fitted, without the edges."""
    where, edge = np.flatnonzero(seen), int(EDGE * RATE)
    first = max(int(where[0]), int(FITTED * len(seen))) + edge
    if int(where[-1]) - edge - first < edge:
        raise ValueError(f"the IMU saw {len(where) / RATE:.3g} s of the motion: too few to judge")
    return slice(first, int(where[-1]) - edge)


def _measures(one: ImuComparison, gravity: Array) -> PredictionErrors:
    """gravity: that was fitted; what the accelerometer sees beside the motion is measured."""
    seen = gravity - one.acceleration_error
    mean = seen.mean(axis=0)
    return PredictionErrors(
        angular_velocity=rms(one.angular_velocity_predicted),
        angular_velocity_error=rms(one.angular_velocity_error),
        acceleration=rms(one.acceleration_predicted),
        acceleration_error=rms(one.acceleration_error),
        gravity=mean,
        gravity_angle=float(_angle(mean[None], gravity)[0]),
        gravity_angle_rms=float(np.sqrt((_angle(seen, gravity) ** 2).mean())),
    )


def _angle(vectors: Array, axis: Array) -> Array:
    """Angles (K,) [rad] of vectors (K, 3) with an axis (3,)."""
    across = np.linalg.norm(np.cross(vectors, axis), axis=1)
    return np.arctan2(across, vectors @ axis)


@dataclass(frozen=True, kw_only=True, eq=False)
class Repeatability:
    """Largest differences between any two recordings."""

    gyro_scale: float
    accelerometer_scale: float
    """Of the singular values of M."""
    mounting: float
    """[rad], angle of the rotation between two mountings by the gyro."""
    lever: Array
    """(3,) [m]."""
    gravity: float
    """[rad], angle between two directions of gravity in base axes."""


def repeatability(alignments: Sequence[ImuAlignment]) -> Repeatability:
    """Differences between two alignments or more. Raises ValueError for fewer."""
    if len(alignments) < 2:
        raise ValueError(f"repeatability needs two recordings, got {len(alignments)}")
    pairs = list(combinations(alignments, 2))

    def largest(values: Iterable[Array]) -> float:
        return float(np.ptp(list(values), axis=0).max())

    return Repeatability(
        gyro_scale=largest(scale(one.M_gyro) for one in alignments),
        accelerometer_scale=largest(scale(one.M_accelerometer) for one in alignments),
        mounting=max(
            float(Rotation.from_matrix(a.R_imu_tool @ b.R_imu_tool.T).magnitude()) for a, b in pairs
        ),
        lever=np.ptp([one.lever for one in alignments], axis=0),
        gravity=max(float(_angle(a.gravity[None], b.gravity)[0]) for a, b in pairs),
    )


def scale(M: Array) -> Array:
    """(3,), singular values of a sensor's matrix, the largest first."""
    return np.linalg.svd(M)[1]


def mounting(one: ImuAlignment) -> Array:
    """(3,) [rad], rotation vector of the axes of the tool in those of the housing."""
    return Rotation.from_matrix(one.R_imu_tool).as_rotvec()
