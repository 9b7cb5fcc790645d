"""Options of the virtual IMU: what its data sheet would say."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from cyclopts import Group, Parameter

from armside.sim.instruments.imu import ACCELEROMETER, GYROSCOPE, ImuCfg

from .options import Limits, options

_IMU = Parameter(group=Group("Virtual IMU", sort_key=5))
STANDARD = ImuCfg()
LIMITS = {
    "imu_rate": Limits(10.0, 1000.0, "Hz"),
    "accelerometer_noise": Limits(0.0, 1.0, "m/s^2 a root Hz"),
    "gyroscope_noise": Limits(0.0, 10.0, "deg/s a root Hz"),
    "accelerometer_bias": Limits(0.0, 10.0, "m/s^2"),
    "gyroscope_bias": Limits(0.0, 100.0, "deg/s"),
    "mounting_error": Limits(0.0, 10.0, "deg"),
    "clock_offset": Limits(0.0, 100.0, "ms"),
    "clock_drift": Limits(0.0, 1000.0, "ppm"),
}


@options
@dataclass(frozen=True, kw_only=True)
class UnitCfg:
    """Rate, errors and clock of the IMU. Errors are one standard deviation, drawn by the seed."""

    imu_rate: Annotated[float, _IMU] = STANDARD.rate
    """Readings a second [Hz]."""
    accelerometer_noise: Annotated[float, _IMU] = ACCELEROMETER.noise_density
    """Noise density [m/s^2 a root Hz]."""
    gyroscope_noise: Annotated[float, _IMU] = round(float(np.rad2deg(GYROSCOPE.noise_density)), 6)
    """Noise density [deg/s a root Hz]."""
    accelerometer_bias: Annotated[float, _IMU] = ACCELEROMETER.bias
    """Bias at turn-on [m/s^2]."""
    gyroscope_bias: Annotated[float, _IMU] = round(float(np.rad2deg(GYROSCOPE.bias)), 6)
    """Bias at turn-on [deg/s]."""
    mounting_error: Annotated[float, _IMU] = round(float(np.rad2deg(STANDARD.mounting_error)), 6)
    """Rotation of the housing about each of its axes [deg]."""
    clock_offset: Annotated[float | None, _IMU] = None
    """Largest offset of its clock [ms; default: 10, at rest 0]."""
    clock_drift: Annotated[float, _IMU] = 1e6 * STANDARD.clock_drift
    """Error of its clock's rate [ppm]."""

    def unit(self, clock_offset: float) -> ImuCfg:
        """The IMU of these options. clock_offset [s]: of the experiment, if none was given."""
        offset = clock_offset if self.clock_offset is None else 1e-3 * self.clock_offset
        accelerometer = replace(
            ACCELEROMETER, noise_density=self.accelerometer_noise, bias=self.accelerometer_bias
        )
        gyroscope = replace(
            GYROSCOPE,
            noise_density=np.deg2rad(self.gyroscope_noise),
            bias=np.deg2rad(self.gyroscope_bias),
        )
        return ImuCfg(
            accelerometer=accelerometer,
            gyroscope=gyroscope,
            rate=self.imu_rate,
            mounting_error=np.deg2rad(self.mounting_error),
            clock_offset=offset,
            clock_drift=1e-6 * self.clock_drift,
        )
