"""Strap-down inertial measurement unit of the Xsens MTx kind, on its own clock.

Ideal reading in the frame of the site -> mounting error -> scale and misalignment -> noise ->
bandwidth -> bias and its walk -> range -> quantisation -> samples on the unit's clock. Noise passes
the sensor's low-pass as the signal does: 0.002 m/s^2/sqrt(Hz) through 30 Hz is 0.012 m/s^2 rms.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array
from armside.ilc.filters import butterworth, recursion
from armside.kinematics.rotation import from_axis_angle

from . import noise
from .noise import rate_of

WARM_UP = 0.5
"""Time before the record in which filters and noise become stationary [s]."""


def _check_not_negative(cfg: object, *names: str) -> None:
    for name in names:
        if not getattr(cfg, name) >= 0.0:
            raise ValueError(f"{name} must be >= 0, got {getattr(cfg, name)}")


@dataclass(frozen=True, kw_only=True)
class TriadCfg:
    """Three orthogonal sensors of one kind. `unit` is m/s^2 or rad/s; errors are one sigma."""

    noise_density: float
    """One-sided, [unit/sqrt(Hz)]."""
    bandwidth: float
    """Corner of a second-order low-pass [Hz]."""
    bias: float
    bias_walk: float
    """Turn-on bias [unit] and its random walk [unit/sqrt(s)]."""
    scale_error: float
    misalignment: float
    """Of the scale, relative, and of each sensitive axis from its housing axis [rad]."""
    range: float
    """Readings are clipped at +-range [unit]."""
    bits: int = 16
    """Resolution of the converter over the whole range; 0 does not quantise."""

    def __post_init__(self) -> None:
        errors = "bias", "bias_walk", "scale_error", "misalignment"
        _check_not_negative(self, "noise_density", *errors, "bits")
        for name in ("bandwidth", "range"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, got {getattr(self, name)}")

    @property
    def resolution(self) -> float:
        """One count [unit], 0 without quantisation."""
        return 2.0 * self.range / 2**self.bits if self.bits else 0.0

    @property
    def delay(self) -> float:
        """Delay [s] of slow signals by the low-pass: sqrt(2) / (2 pi bandwidth)."""
        return float(np.sqrt(2.0) / (2.0 * np.pi * self.bandwidth))

    def low_passed(self, signal: Array, step: float) -> Array:
        """Signal (N, n) with samples every `step` [s] after the low-pass, which starts at zero."""
        for b, a in butterworth(self.bandwidth, step, 2):
            signal = recursion(b, a, signal)
        return signal


ACCELEROMETER = TriadCfg(
    noise_density=0.002,  # data sheet MT0100P, +-17 m/s^2 unit
    bandwidth=30.0,  # data sheet, from memory
    bias=0.02,  # bias stability of the manual
    bias_walk=1e-4,  # ESTIMATE
    scale_error=3e-4,  # stability of scale, from memory
    misalignment=np.deg2rad(0.1),  # data sheet MT0100P
    range=17.0,  # +-1.7 g, thesis 5.1.1
)
GYROSCOPE = TriadCfg(
    noise_density=np.deg2rad(0.1),  # data sheet MT0100P, +-1200 deg/s unit
    bandwidth=40.0,  # data sheet, from memory
    bias=np.deg2rad(1.0),  # bias stability of the manual
    bias_walk=1e-5,  # ESTIMATE
    scale_error=3e-4,  # stability of scale, from memory
    misalignment=np.deg2rad(0.1),  # data sheet MT0100P
    range=np.deg2rad(1200.0),  # thesis 5.1.1
)


@dataclass(frozen=True, kw_only=True)
class ImuCfg:
    """IMU with its mounting and clock."""

    accelerometer: TriadCfg = ACCELEROMETER
    gyroscope: TriadCfg = GYROSCOPE
    rate: float = 100.0
    """Output rate [Hz]. Thesis 5.1.1."""
    mounting_error: float = np.deg2rad(0.7)
    """One standard deviation of the housing's rotation about each axis of the site [rad]. ESTIMATE:
    the mean of -0.2 m/s^2 in thesis Fig. 5.2 is a tilt of 1.2 deg."""
    clock_offset: float = 0.010
    """The unit's clock starts within +- this of the robot's [s]. ESTIMATE."""
    clock_drift: float = 0.0
    """One standard deviation of its rate error, relative."""

    def __post_init__(self) -> None:
        if not self.rate > 0.0:
            raise ValueError(f"IMU rate must be > 0 Hz, got {self.rate}")
        _check_not_negative(self, "mounting_error", "clock_offset", "clock_drift")


@dataclass(frozen=True, kw_only=True)
class ImuSamples:
    """Samples of an IMU, in its own frame and on its own clock."""

    time: Array
    """(K,) [s], the unit's clock."""
    acceleration: Array
    """(K, 3) [m/s^2], specific force: gravity shows as an acceleration upwards."""
    angular_velocity: Array
    """(K, 3) [rad/s]."""
    acceleration_clipped: NDArray[np.bool_]
    angular_velocity_clipped: NDArray[np.bool_]
    """(K, 3), True for a reading at the end of its range."""


@dataclass(frozen=True, kw_only=True)
class Triad:
    """Individual triad: y = sensitivity @ x + bias."""

    cfg: TriadCfg
    sensitivity: Array
    """(3, 3), identity for a perfect one."""
    bias: Array
    """(3,) [unit], at the start."""

    def filtered(self, ideal: Array, step: float, rng: np.random.Generator) -> Array:
        """Noise and low-pass at the rate of the record, stationary from the start; (M, 3)."""
        n_warm = round(WARM_UP / step)
        x = np.concatenate([np.repeat(ideal[:1], n_warm, axis=0), ideal]) @ self.sensitivity.T
        y = x + noise.from_density(rng, x.shape, self.cfg.noise_density, 1.0 / step)
        return self.cfg.low_passed(y, step)[n_warm:]

    def digitised(
        self, samples: Array, period: float, rng: np.random.Generator
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Bias, range and converter at the output rate: readings, and a mask of clipped ones."""
        cfg = self.cfg
        y = samples + self.bias + noise.random_walk(rng, samples.shape, cfg.bias_walk, period)
        clipped = np.abs(y) >= cfg.range
        y = np.clip(y, -cfg.range, cfg.range)
        if cfg.resolution > 0.0:
            y = np.clip(np.rint(y / cfg.resolution) * cfg.resolution, -cfg.range, cfg.range)
        return y, clipped


@dataclass(frozen=True, kw_only=True)
class Imu:
    """Individual IMU, mounted on the robot; see `draw`."""

    cfg: ImuCfg
    accelerometer: Triad
    gyroscope: Triad
    R_site_imu: Array
    """(3, 3), the mounting error."""
    clock_offset: float
    clock_drift: float
    """Robot time [s] = clock_offset + (1 + clock_drift) * unit time."""

    def measure(
        self, time: Array, acceleration: Array, angular_velocity: Array, rng: np.random.Generator
    ) -> ImuSamples:
        """Readings of a record of ideal specific force [m/s^2] and rate [rad/s], (M, 3) in the
        frame of the site, interpolated linearly at the unit's instants after the low-pass.

        time: (M,) [s], uniform, robot time; fine enough for the bandwidths.
        """
        step = 1.0 / rate_of(time)
        own_time, robot_time = self._instants(time)
        readings = []
        ideals = (self.accelerometer, acceleration), (self.gyroscope, angular_velocity)
        for triad, ideal in ideals:
            fine = triad.filtered(ideal @ self.R_site_imu, step, rng)
            at_samples = np.stack([np.interp(robot_time, time, c) for c in fine.T], axis=1)
            readings.append(triad.digitised(at_samples, 1.0 / self.cfg.rate, rng))
        (a, a_clipped), (w, w_clipped) = readings
        return ImuSamples(
            time=own_time,
            acceleration=a,
            angular_velocity=w,
            acceleration_clipped=a_clipped,
            angular_velocity_clipped=w_clipped,
        )

    def _instants(self, time: Array) -> tuple[Array, Array]:
        """Sample times within a record: on the unit's clock and on the robot's."""
        pace = 1.0 + self.clock_drift
        first, last = ((time[[0, -1]] - self.clock_offset) / pace) * self.cfg.rate
        own = np.arange(np.ceil(first - 1e-9), np.floor(last + 1e-9) + 1) / self.cfg.rate
        return own, self.clock_offset + pace * own


def draw(cfg: ImuCfg, rng: np.random.Generator) -> Imu:
    """Random individual of an IMU, with errors that are constant over an experiment."""
    return Imu(
        cfg=cfg,
        accelerometer=_draw_triad(cfg.accelerometer, rng),
        gyroscope=_draw_triad(cfg.gyroscope, rng),
        R_site_imu=from_vector(cfg.mounting_error * rng.standard_normal(3)),
        clock_offset=float(rng.uniform(-cfg.clock_offset, cfg.clock_offset)),
        clock_drift=float(cfg.clock_drift * rng.standard_normal()),
    )


def exact(cfg: ImuCfg) -> Imu:
    """Unit of a kind without errors, mounted right and on the robot's clock: rate and bandwidths of
    its data sheet alone."""
    perfect = {"noise_density": 0.0, "bias": 0.0, "bias_walk": 0.0, "scale_error": 0.0}
    triads = {
        name: replace(getattr(cfg, name), **perfect, misalignment=0.0, bits=0)
        for name in ("accelerometer", "gyroscope")
    }
    on_time = {"clock_offset": 0.0, "clock_drift": 0.0}
    return draw(replace(cfg, **triads, **on_time, mounting_error=0.0), np.random.default_rng(0))


def _draw_triad(cfg: TriadCfg, rng: np.random.Generator) -> Triad:
    scale = np.diag(cfg.scale_error * rng.standard_normal(3))
    tilt = cfg.misalignment * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    return Triad(
        cfg=cfg, sensitivity=np.eye(3) + scale + tilt, bias=cfg.bias * rng.standard_normal(3)
    )


def from_vector(vector: ArrayLike) -> Array:
    """Rotation matrix of a rotation vector (3,) [rad]; none for zero."""
    v = np.asarray(vector, dtype=np.float64)
    angle = float(np.linalg.norm(v))
    return from_axis_angle(v, angle) if angle > 0.0 else np.eye(3)
