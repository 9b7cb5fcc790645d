"""IMU at the tool as the sensor of identification: readings less what a twin explains.

    residual = P Q (reading - L s - by motors) / noise

s is the ideal reading of a twin, L the low-pass and the sampling of the unit, "by motors" what
kinematics makes of the difference between measured and simulated motor angles. Q is a low-pass: no
twin is right above it. P takes out what errors of the unit explain: bias and its drift, mounting,
scale, misalignment, clock.

Errors of geometry move the tool too slowly for an accelerometer: they have no sensitivities. The
gyroscope is left out: at 5 Hz the tool's motion is 30 times smaller to it, in its own noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.imu_health import ImuError, repaired
from ..estimation.rigid_motion import ENCODER_FILTER
from ..instruments.imu import ImuCfg, ImuSamples
from ..robot.mjcf import N_AXES
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .recordings import ImplausibleError, MeasuredCut
from .simulation import motor_path
from .tool_sensor import ImuKinematics, ToolSensor, gear_waves, imu_kinematics

CFG = ImuCfg()
"""Kind of unit, as its data sheet has it."""
CUTOFF = 10.0
"""[Hz], of Q."""
_FREE = 1e3
"""Standard deviation of bias and its drift [m/s^2]: nothing is known of them."""
_EXACT = 1e-9
"""Standard deviation of what a data sheet says to be exact."""
_SYNCHRONISED = 3.0
"""[Hz], below which readings are compared: springs hardly delay them."""
_REST = 10
"""Samples before the arm moves: 0.1 s."""
_LARGEST_TILT = 0.1
"""Of gravity, by which a reading at rest may differ from the nominal robot's: mounting errors are a
tenth of it. ESTIMATE."""


def unit_errors(time: Array, reading: Array, cfg: ImuCfg) -> tuple[Array, Array]:
    """Columns (K, 3, 19) [m/s^2] of bias and its drift, mounting, scale and misalignment, clock,
    for small errors of a reading (K, 3); and their standard deviations (19,)."""
    n, unit, triad = len(reading), np.eye(3), cfg.accelerometer
    ramp = np.linspace(-1.0, 1.0, n)
    bias = np.concatenate((np.tile(unit, (n, 1, 1)), ramp[:, None, None] * unit), axis=2)
    mounting = np.stack([np.cross(reading, axis) for axis in unit], axis=2)
    sensitivity = (unit[None, :, :, None] * reading[:, None, None, :]).reshape(n, 3, 9)
    clock = np.gradient(reading, time, axis=0)[:, :, None]
    errors = np.where(unit > 0.0, triad.scale_error, triad.misalignment).ravel()
    known = np.concatenate((np.full(3, cfg.mounting_error), errors, [cfg.clock_offset]))
    deviation = np.concatenate((np.full(6, _FREE), np.maximum(known, _EXACT)))
    return np.concatenate((bias, mounting, sensitivity, clock), axis=2), deviation


def clock_offset(
    unit_time: Array, reading: Array, expected: Array, step: float, largest: float
) -> float:
    """Robot time less unit time [s], by least squares of readings (K, 3) on expected ones (N, 3).

    Those start at robot time 0, `step` [s] apart; an affine map of them stands for bias, mounting
    and scale. Twice the `largest` offset [s] is searched.
    """
    from scipy.optimize import OptimizeResult, minimize_scalar

    period = float(unit_time[1] - unit_time[0])
    smooth = ZeroPhaseButterworth(_SYNCHRONISED, period)(reading)
    expected = ZeroPhaseButterworth(_SYNCHRONISED, step)(expected)
    time = np.arange(len(expected)) * step

    def misfit(offset: float) -> float:
        moved = [np.interp(unit_time + offset, time, column) for column in expected.T]
        A = np.column_stack((*moved, np.ones(len(unit_time))))
        left = smooth - A @ np.linalg.lstsq(A, smooth, rcond=None)[0]
        return float(np.sum(left**2))

    bound = 2.0 * largest + period
    found = minimize_scalar(misfit, bounds=(-bound, bound), method="bounded")
    assert isinstance(found, OptimizeResult)
    return float(found.x)


def check_imu(model: RobotModel, cut: MeasuredCut, against_nominal: bool = True) -> None:
    """Raise ImplausibleError for a cut without an IMU, or against the nominal robot."""
    if cut.imu is None:
        raise ImplausibleError(f"{cut.name} has no samples of an IMU")
    try:
        rest = np.nanmean(repaired(cut.imu, CFG).acceleration[:_REST], axis=0)
    except ImuError as error:
        raise ImplausibleError(f"{cut.name}: {error}") from error
    if not against_nominal:
        return
    still = cut.motor_angle[:1].repeat(3, axis=0)
    expected = imu_kinematics(model, still, LOG_PERIOD).reading[0]
    off = float(np.linalg.norm(rest - expected) / np.linalg.norm(expected))
    if off > _LARGEST_TILT:
        raise ImplausibleError(
            f"{cut.name}: the IMU reads {_vector(rest)} m/s^2 at rest, where gravity is "
            f"{_vector(expected)}: another mounting, or another unit"
        )


@dataclass(frozen=True, eq=False)
class ImuComparison:
    """See `CutComparison`. Residuals are in units of the unit's white noise."""

    model: RobotModel
    cut: MeasuredCut

    @cached_property
    def samples(self) -> ImuSamples:
        """On an even timeline, NaN where one is missing."""
        assert self.cut.imu is not None
        return repaired(self.cut.imu, CFG)

    def residual(self, run: Recording) -> Array:
        ideal, step = _ideal(run)
        offset = self._offset(ideal, step)
        by_motors = self._kinematics.change(self._smooth - motor_path(run))
        expected = self._sampled(ideal, step, offset)
        expected += self._sampled(by_motors, LOG_PERIOD, offset)
        return self._cleaned(self._reading - expected)

    def change(self, base: Recording, run: Recording) -> Array:
        (before, step), (after, _) = _ideal(base), _ideal(run)
        offset = self._offset(before, step)
        by_motors = self._kinematics.change(motor_path(run) - motor_path(base))
        change = self._sampled(after - before, step, offset)
        return self._cleaned(change - self._sampled(by_motors, LOG_PERIOD, offset))

    def by_kinematics(self) -> Mapping[str, Array]:
        waves = gear_waves(self.model, self.cut.motor_angle).reshape(-1, N_AXES, 1, 8)
        each = (np.eye(N_AXES)[:, :, None] * waves).reshape(-1, N_AXES, N_AXES * 8)
        change = self._kinematics.change(each)
        return {"gear_error": self._cleaned(self._sampled(change, LOG_PERIOD, self._rigid_offset))}

    def _sampled(self, ideal: Array, step: float, offset: float) -> Array:
        """Readings (K, 3, ...) of the unit for ideal ones (M, 3, ...), every `step` [s] from robot
        time 0; offset: robot time less unit time [s]."""
        filtered = _filtered(ideal, step)
        at = np.clip((self.samples.time + offset) / step, 0.0, len(ideal) - 1.0)
        i = np.minimum(at.astype(int), len(ideal) - 2)
        fraction = (at - i).reshape(-1, *[1] * (ideal.ndim - 1))
        return np.asarray((1.0 - fraction) * filtered[i] + fraction * filtered[i + 1])

    @cached_property
    def _smooth(self) -> Array:
        return ZeroPhaseButterworth(ENCODER_FILTER, LOG_PERIOD)(self.cut.motor_angle)

    @cached_property
    def _kinematics(self) -> ImuKinematics:
        return imu_kinematics(self.model, self._smooth, LOG_PERIOD)

    @cached_property
    def _reading(self) -> Array:
        """(K, 3) [m/s^2]; missing samples are interpolated."""
        time, reading = self.samples.time, self.samples.acceleration
        there = np.isfinite(reading).all(axis=1)
        return np.column_stack([np.interp(time, time[there], c[there]) for c in reading.T])

    def _offset(self, ideal: Array, step: float) -> float:
        """Robot time less unit time [s], by ideal readings (M, 3)."""
        expected = _filtered(ideal, step)
        return clock_offset(self.samples.time, self._reading, expected, step, CFG.clock_offset)

    @cached_property
    def _rigid_offset(self) -> float:
        """By the rigid arm: some milliseconds off where springs swing."""
        return self._offset(self._kinematics.reading, LOG_PERIOD)

    def _cleaned(self, reading: Array) -> Array:
        """P Q of readings (K, 3, ...), in units of white noise."""
        low = self._low_passed(reading).reshape(3 * len(reading), -1)
        errors, fit = self._errors
        return (low - errors @ (fit @ low)).reshape(reading.shape)

    @cached_property
    def _errors(self) -> tuple[Array, Array]:
        """Columns (3 K, e) of the unit's errors, and the matrix that fits them."""
        columns, deviation = unit_errors(self.samples.time, self._reading, CFG)
        A = self._low_passed(columns).reshape(-1, len(deviation))
        return A, np.asarray(np.linalg.solve(A.T @ A + np.diag(deviation**-2.0), A.T), np.float64)

    def _low_passed(self, reading: Array) -> Array:
        noise = CFG.accelerometer.noise_density * np.sqrt(0.5 * CFG.rate)
        smooth = ZeroPhaseButterworth(CUTOFF, 1.0 / CFG.rate)
        return smooth(reading.reshape(len(reading), -1) / noise).reshape(reading.shape)


def _filtered(ideal: Array, step: float) -> Array:
    """Ideal readings (M, 3, ...) through the unit's low-pass, from rest."""
    moved = (ideal - ideal[0]).reshape(len(ideal), -1)
    return ideal[0] + CFG.accelerometer.low_passed(moved, step).reshape(ideal.shape)


def _ideal(run: Recording) -> tuple[Array, float]:
    """Readings (M, 3) [m/s^2] of a twin's ideal accelerometer, and the time between them [s]."""
    return run.truth.imu_acceleration, float(run.truth.time[1] - run.truth.time[0])


def _vector(values: Array) -> str:
    return f"[{', '.join(f'{value:.3g}' for value in values)}]"


IMU = ToolSensor(
    noise=1.0,
    correlation=float(1.0 / np.sqrt(2.0 * CUTOFF / CFG.rate)),
    quantity="acceleration of the tool",
    unit="× noise",
    factor=1.0,
    displacement=20e-6,  # at 4 Hz. ESTIMATE.
    unsuspicious=5.0,
    check=check_imu,
    comparison=ImuComparison,
)
