"""An IMU aligned with the encoders: its clock and delays, and what it feels of a turn."""

import numpy as np
import pytest

from armside.kinematics import compile
from armside.sim.recordings import Stream
from armside.sim.recordings.alignment.encoder_motion import encoder_motion
from armside.sim.recordings.alignment.imu_alignment import GRAVITY, ImuAlignment, align_imu


def test_drift_of_the_clock_and_the_delay_of_each_sensor_are_found(scenes):
    scene = scenes.Scene(1, imu_rate=400e-6, accelerometer_late=0.03)
    one = scenes.recording(scene)
    found = align_imu(encoder_motion(compile(scenes.ARM.robot), one.encoders), one.imu)
    assert found.rate == pytest.approx(400e-6, abs=20e-6)
    assert found.gyro_delay == pytest.approx(0.1, abs=1e-3)
    assert found.accelerometer_delay == pytest.approx(0.13, abs=1e-3)


def test_a_steady_turn_is_felt_as_speed_squared_times_the_whole_distance(scenes):
    """Joint 1 turns a stretched arm about the vertical at 2 rad/s."""
    speed, reach, lever = 2.0, 0.5 + 0.4, 0.1
    time = np.arange(0.0, 2.0, 0.01)
    phi = np.column_stack([speed * time, 0.0 * time, 0.0 * time])
    motion = encoder_motion(compile(scenes.ARM.robot), Stream(time, phi))
    one = ImuAlignment(
        gyro_delay=0.0,
        accelerometer_delay=0.0,
        rate=0.0,
        M_gyro=np.eye(3),
        M_accelerometer=np.eye(3),
        gyro_bias=np.zeros(3),
        accelerometer_bias=np.zeros(3),
        lever=np.array([lever, 0.0, 0.0]),
        gravity=GRAVITY,
    )
    middle = len(time) // 2
    force, rate = np.split(one.predicted(motion)[middle], 2)
    inward = -np.array([np.cos(phi[middle, 0]), np.sin(phi[middle, 0]), 0.0])
    np.testing.assert_allclose(force, speed**2 * (reach + lever) * inward - GRAVITY, rtol=1e-3)
    np.testing.assert_allclose(rate, [0.0, 0.0, speed], atol=1e-3)
