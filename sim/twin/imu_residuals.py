"""Residuals of an IMU at the tool, in bands of frequency.

    residual = P B (reading - L s - by motors)

s is the ideal reading of a twin, L the low-pass and the sampling of the unit, "by motors" what
kinematics makes of the difference between measured and simulated motor angles. B is a bank of
band-passes, each with a scale of its own: elasticity that a twin lacks shows at high frequencies,
the tool moves at low ones, and an error of position counts in an acceleration with the square of
frequency. P takes out what errors of the unit explain.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth

from ..estimation.imu_health import repaired
from ..estimation.observer import ENCODER_FILTER
from ..instruments.imu import ImuCfg, ImuSamples, Triad, TriadCfg
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.virtual_robot import LOG_PERIOD
from .imu_bands import TriadBands
from .imu_kinematics import ImuKinematics, imu_kinematics
from .kinematic_columns import gear_waves
from .measured import MeasuredCut
from .simulation import motor_path
from .tool_sensor import Channels
from .unit_errors import clock_offset


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
        time, ideal = _ideal(run)
        offset = self._offset(time, ideal)
        simulated = self._sampled(time, ideal, offset)
        by_motors = self._by_motors(self._smooth - motor_path(run), offset)
        return self._banded(self._reading - simulated - by_motors)

    def change(self, base: Recording, run: Recording) -> Array:
        (time, before), (_, after) = _ideal(base), _ideal(run)
        offset = self._offset(time, before)
        by_motors = self._by_motors(motor_path(run) - motor_path(base), offset)
        return self._banded(self._sampled(time, after - before, offset) - by_motors)

    def gear_errors(self) -> Array:
        waves = gear_waves(self.model, self.motor_angle)
        moved = self._kinematics.jacobian[:, :, :, None, None] * waves[:, None]
        change = self._kinematics.change(moved.reshape(*moved.shape[:2], -1))
        return self._banded(self._sampled(self._log, change, self._rigid_offset))

    def geometry(self) -> None:
        """Errors of geometry move the tool too slowly for an IMU."""

    @property
    def _log(self) -> Array:
        return np.arange(len(self.motor_angle)) * LOG_PERIOD

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

    def _offset(self, time: Array, ideal: Array) -> float:
        """Robot time less unit time [s], by ideal readings (M, 6)."""
        force = self._filtered(time, ideal)[:, :3]
        largest = self.sensor.cfg.clock_offset
        return clock_offset(self.samples.time, self._reading[:, :3], time, force, largest)

    @cached_property
    def _rigid_offset(self) -> float:
        """By the rigid arm: some milliseconds off where springs swing."""
        return self._offset(self._log, self._kinematics.reading)

    def _by_motors(self, moved: Array, offset: float) -> Array:
        displaced = np.einsum("kij,kj->ki", self._kinematics.jacobian, moved)
        return self._sampled(self._log, self._kinematics.change(displaced), offset)

    def _sampled(self, time: Array, ideal: Array, offset: float) -> Array:
        """(K, 6, ...), readings of the unit without its errors, of ideal ones (M, 6, ...)."""
        filtered, step = self._filtered(time, ideal), float(time[1] - time[0])
        at = np.clip(self.samples.time + offset, time[0], time[-1]) / step
        i = np.minimum(at.astype(int), len(time) - 2)
        fraction = (at - i).reshape(-1, *[1] * (ideal.ndim - 1))
        return np.asarray((1.0 - fraction) * filtered[i] + fraction * filtered[i + 1])

    def _filtered(self, time: Array, ideal: Array) -> Array:
        step = float(time[1] - time[0])
        return self._by_triad(ideal, lambda i, part: _low_passed(self._triads[i], part, step))

    def _banded(self, reading: Array) -> Array:
        """(K, C, ...) of readings (K, 6, ...)."""
        flat = reading.reshape(*reading.shape[:2], -1)
        bands = self._by_triad(flat, lambda i, part: self._bands[i](part))
        return bands.reshape(*bands.shape[:2], *reading.shape[2:])

    @cached_property
    def _bands(self) -> tuple[TriadBands, ...]:
        cfg, rigid = self.sensor.cfg, self._kinematics.reading
        expected = self._sampled(self._log, rigid, self._rigid_offset)
        parts = zip(self._triads, np.split(expected, 2, axis=1), strict=True)
        time, edges = self.samples.time, self.sensor.edges
        return tuple(TriadBands(cfg, triad, edges, time, part) for triad, part in parts)

    @property
    def _triads(self) -> tuple[TriadCfg, TriadCfg]:
        return self.sensor.cfg.accelerometer, self.sensor.cfg.gyroscope

    @staticmethod
    def _by_triad(reading: Array, function: Callable[[int, Array], Array]) -> Array:
        parts = enumerate(np.split(reading, 2, axis=1))
        return np.asarray(
            np.concatenate([function(i, part) for i, part in parts], axis=1), np.float64
        )


def _ideal(run: Recording) -> tuple[Array, Array]:
    """Time (M,) [s], and readings (M, 6) of a twin's ideal unit."""
    truth = run.truth
    return truth.time, np.hstack((truth.imu_acceleration, truth.imu_angular_velocity))


def _low_passed(cfg: TriadCfg, ideal: Array, step: float) -> Array:
    """Ideal readings (M, 3, ...) through the low-pass of a triad."""
    flat = ideal.reshape(len(ideal), -1)
    n = flat.shape[1]
    exact = Triad(cfg=replace(cfg, noise_density=0.0), sensitivity=np.eye(n), bias=np.zeros(n))
    return exact.filtered(flat, step, np.random.default_rng()).reshape(ideal.shape)
