"""Residuals of an IMU at the tool, in bands of frequency.

    residual = P B (reading - L s - by motors)

s is the ideal reading of a twin, L the low-pass and the sampling of the unit, "by motors" what
kinematics makes of the difference between measured and simulated motor angles. B is a bank of
band-passes, each with a scale of its own: elasticity that a twin lacks shows at high frequencies,
the tool moves at low ones, and an error of position counts in an acceleration with the square of
frequency. P takes out what errors of the unit explain.

Errors of geometry move the tool too slowly for an IMU: they have no sensitivities.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.imu_health import repaired
from ..estimation.observer import ENCODER_FILTER
from ..instruments.imu import ImuCfg, ImuSamples
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .imu_bands import TriadBands
from .imu_kinematics import ImuKinematics, imu_kinematics
from .imu_sampling import ImuSampling, halves
from .kinematic_columns import gear_waves
from .measured import MeasuredCut
from .simulation import motor_path
from .tool_sensor import Channels
from .unit_clock import clock_offset


@dataclass(frozen=True, kw_only=True)
class ImuSensor:
    """IMU as the sensor of identification."""

    cfg: ImuCfg = field(default_factory=ImuCfg)
    """Kind of unit, as its data sheet has it."""
    edges: tuple[float, ...] = (1.5, 3.0, 6.0, 10.0)
    """Upper edges of the bands [Hz]."""

    @property
    def channels(self) -> tuple[Channels, ...]:
        """Bands of the accelerometer, then of the gyroscope, in units of white noise."""
        independent = np.tile(np.diff(self.edges, prepend=0.0) * 2.0 / self.cfg.rate, 2)
        return tuple(
            Channels(slice(3 * i, 3 * i + 3), 1.0, float(1.0 / np.sqrt(fraction)))
            for i, fraction in enumerate(independent)
        )

    def comparison(self, model: RobotModel, cut: MeasuredCut) -> "ImuComparison":
        if cut.imu is None:
            raise ValueError(f"{cut.name} has no samples of an IMU")
        return ImuComparison(self, model, cut.motor_angle, repaired(cut.imu, self.cfg))


@dataclass(frozen=True, eq=False)
class ImuComparison:
    """See `Comparison`."""

    sensor: ImuSensor
    model: RobotModel
    motor_angle: Array
    samples: ImuSamples
    """On an even timeline, NaN where one is missing."""

    def residual(self, run: Recording) -> Array:
        ideal, step = _ideal(run)
        offset = self._offset(ideal, step)
        simulated = self._sampling(ideal, step, offset)
        by_motors = self._by_motors(self._smooth - motor_path(run), offset)
        return self._banded(self._reading - simulated - by_motors)

    def change(self, base: Recording, run: Recording) -> Array:
        (before, step), (after, _) = _ideal(base), _ideal(run)
        offset = self._offset(before, step)
        by_motors = self._by_motors(motor_path(run) - motor_path(base), offset)
        return self._banded(self._sampling(after - before, step, offset) - by_motors)

    def by_kinematics(self) -> Mapping[str, Array]:
        waves = gear_waves(self.model, self.motor_angle)
        moved = self._kinematics.jacobian[:, :, :, None, None] * waves[:, None]
        change = self._kinematics.change(moved.reshape(*moved.shape[:2], -1))
        return {"gear_error": self._banded(self._sampling(change, LOG_PERIOD, self._rigid_offset))}

    @cached_property
    def _sampling(self) -> ImuSampling:
        return ImuSampling(self.sensor.cfg, self.samples.time)

    @cached_property
    def _smooth(self) -> Array:
        return ZeroPhaseButterworth(ENCODER_FILTER, LOG_PERIOD)(self.motor_angle)

    @cached_property
    def _kinematics(self) -> ImuKinematics:
        return imu_kinematics(self.model, self._smooth, LOG_PERIOD)

    @cached_property
    def _reading(self) -> Array:
        """(K, 6); missing samples are interpolated."""
        time = self.samples.time
        reading = np.hstack((self.samples.acceleration, self.samples.angular_velocity))
        there = np.isfinite(reading).all(axis=1)
        return np.column_stack([np.interp(time, time[there], c[there]) for c in reading.T])

    def _offset(self, ideal: Array, step: float) -> float:
        """Robot time less unit time [s], by ideal readings (M, 6)."""
        measured, _ = halves(self._reading)
        expected, _ = halves(self._sampling.filtered(ideal, step))
        largest = self.sensor.cfg.clock_offset
        return clock_offset(self.samples.time, measured, expected, step, largest)

    @cached_property
    def _rigid_offset(self) -> float:
        """By the rigid arm: some milliseconds off where springs swing."""
        return self._offset(self._kinematics.reading, LOG_PERIOD)

    def _by_motors(self, moved: Array, offset: float) -> Array:
        displaced = np.einsum("kij,kj->ki", self._kinematics.jacobian, moved)
        return self._sampling(self._kinematics.change(displaced), LOG_PERIOD, offset)

    @cached_property
    def _bands(self) -> tuple[TriadBands, ...]:
        cfg, edges, time = self.sensor.cfg, self.sensor.edges, self.samples.time
        expected = self._sampling(self._kinematics.reading, LOG_PERIOD, self._rigid_offset)
        parts = zip((cfg.accelerometer, cfg.gyroscope), halves(expected), strict=True)
        return tuple(TriadBands(cfg, triad, edges, time, part) for triad, part in parts)

    def _banded(self, reading: Array) -> Array:
        """(K, C, ...) of readings (K, 6, ...)."""
        triads = zip(self._bands, halves(reading), strict=True)
        return np.concatenate([bands(part) for bands, part in triads], axis=1)


def _ideal(run: Recording) -> tuple[Array, float]:
    """Readings (M, 6) of a twin's ideal unit, and the time between them [s]."""
    truth = run.truth
    step = float(truth.time[1] - truth.time[0])
    return np.hstack((truth.imu_acceleration, truth.imu_angular_velocity)), step
