"""Chapter 5 on recordings: a synthetic arm, and the AUBO i5."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.kinematics import CATALOGUE
from armside.sim.imu.chapter5_recorded import (
    ImuComparison,
    _measures,
    mounting,
    process,
    repeatability,
    scale,
)
from armside.sim.recordings import read_motion

AUBO = Path(os.environ.get("ARMSIDE_MEASUREMENTS") or ".") / "aubo_i5"
DAYS = ("20200922", "20201015", "20201016")
TILT = (8e-3, -6e-3)


@pytest.fixture(scope="module")
def recordings(scenes):
    """The same IMU on two days: other motions and clocks, a base that is not level."""
    days = (scenes.Scene(1, tilt=TILT), scenes.Scene(2, imu_offset=0.15, tilt=TILT))
    return [scenes.recording(day) for day in days]


@pytest.fixture(scope="module")
def done(scenes, recordings):
    return [process(scenes.ARM, one) for one in recordings]


def test_delays_scale_a_housing_turned_over_lever_and_gravity_are_found(done, scenes):
    for one, offset in zip(done, (0.1, 0.15), strict=True):
        found = one.alignment
        assert abs(found.gyro_delay - offset) < 1e-3
        assert abs(found.accelerometer_delay - offset) < 1e-3
        np.testing.assert_allclose(scale(found.M_gyro), 1.02, atol=2e-3)
        # Gravity stays in the plane of two links: across it accelerations of 0.3 m/s^2 alone tell
        np.testing.assert_allclose(scale(found.M_accelerometer), 1.01, atol=10e-3)
        assert np.degrees(np.linalg.norm(mounting(found))) > 178.0
        turn = found.R_imu_tool @ scenes.MOUNTING.T
        assert np.degrees(np.arccos((np.trace(turn) - 1.0) / 2.0)) < 0.1
        np.testing.assert_allclose(found.lever, scenes.LEVER, atol=20e-3)
        np.testing.assert_allclose(found.gravity[:2], 9.81 * np.array(TILT), atol=5e-3)


def test_what_the_first_half_teaches_predicts_the_second(done):
    """Noise of 2 mrad/s and 0.03 m/s^2 is left, less what the low-pass takes, and the gears."""
    for one in done:
        m = one.measures
        assert one.comparison.time[0] > 0.5 * one.motion.time[-1]
        assert (m.angular_velocity_error < 0.01 * m.angular_velocity).all()
        assert (m.acceleration_error < 0.03).all()
        assert np.degrees(m.gravity_angle) < 0.05
        assert abs(m.gravity_magnitude - 9.81) < 0.01


def test_the_tool_by_the_tracker_is_that_of_the_encoders(done):
    for one in done:
        _, seen, by_encoders = one.tool()
        assert np.abs(seen - by_encoders).max() < 0.5e-3
        assert np.ptp(seen, axis=0).max() > 0.1


def test_errors_of_a_prediction_are_root_mean_squares_and_what_is_left_is_gravity():
    """Measured less predicted is constant: the accelerometer sees gravity otherwise by as much."""
    wave, e = np.array([1.0, -1.0])[:, np.newaxis] * [3.0, 2.0, 1.0], np.array([0.3, 0.0, -0.2])
    one = ImuComparison(
        time=np.arange(2.0),
        angular_velocity_measured=0.1 * wave + [0.01, 0.0, 0.02],
        angular_velocity_predicted=0.1 * wave,
        acceleration_measured=wave + e,
        acceleration_predicted=wave,
        clock_offset=0.0,
    )
    found = _measures(one, np.array([0.0, 0.0, -9.81]))
    np.testing.assert_allclose(found.angular_velocity, [0.3, 0.2, 0.1])
    np.testing.assert_allclose(found.angular_velocity_error, [0.01, 0.0, 0.02], atol=1e-15)
    np.testing.assert_allclose(found.acceleration, [3.0, 2.0, 1.0])
    np.testing.assert_allclose(found.acceleration_error, [0.3, 0.0, 0.2], atol=1e-15)
    np.testing.assert_allclose(found.gravity, [-0.3, 0.0, -9.61], atol=1e-14)
    assert found.gravity_magnitude == pytest.approx(np.hypot(0.3, 9.61))
    assert found.gravity_angle == found.gravity_angle_rms == pytest.approx(np.arctan(0.3 / 9.61))


def test_a_bias_of_a_sensor_is_found_in_its_own_axes(recordings, scenes, done):
    """Added to readings in m/s^2 and rad/s; gravity stays in a plane, across which less is told."""
    one, (bias_a, bias_g) = recordings[0], ([0.05, -0.03, 0.02], [4e-3, -3e-3, 2e-3])
    imu = replace(one.imu, values=np.add(one.imu.values, [*bias_a, *bias_g]))
    shifted, before = process(scenes.ARM, replace(one, imu=imu)).alignment, done[0].alignment
    np.testing.assert_allclose(shifted.gyro_bias - before.gyro_bias, bias_g, atol=2e-4)
    moved = shifted.accelerometer_bias - before.accelerometer_bias
    np.testing.assert_allclose(moved, bias_a, atol=5e-3)


def test_differences_between_recordings_are_those_of_their_constants(done):
    pair = [one.alignment for one in done]
    assert repeatability([pair[0], pair[0]]).mounting == 0.0
    moved = replace(pair[1], M_gyro=1.01 * pair[1].M_gyro)
    assert repeatability([pair[1], moved]).gyro_scale == pytest.approx(0.0102, abs=1e-4)
    assert repeatability(pair).mounting < np.radians(0.1)
    first, turn = pair[0], Rotation.from_rotvec([0.0, 0.02, 0.0]).as_matrix()
    across = np.cross(first.gravity, [1.0, 0.0, 0.0])
    across *= np.linalg.norm(first.gravity) / np.linalg.norm(across)
    other = replace(
        first,
        M_gyro=turn @ first.M_gyro,
        M_accelerometer=1.01 * first.M_accelerometer,
        lever=np.add(first.lever, [1e-3, -2e-3, 0.0]),
        gravity=np.cos(0.03) * first.gravity + np.sin(0.03) * across,
    )
    found = repeatability([first, other])
    assert found.mounting == pytest.approx(0.02, rel=1e-6)
    assert found.accelerometer_scale == pytest.approx(0.0101, abs=2e-4)
    np.testing.assert_allclose(found.lever, [1e-3, 2e-3, 0.0], atol=1e-12)
    assert found.gravity == pytest.approx(0.03, rel=1e-6)
    with pytest.raises(ValueError, match="needs two recordings, got 1"):
        repeatability(pair[:1])


@pytest.mark.skipif(not AUBO.is_dir(), reason="ARMSIDE_MEASUREMENTS names no folder aubo_i5")
def test_the_imu_of_the_aubo_repeats_over_the_days_and_its_gyro_is_predicted():
    arm = CATALOGUE["aubo_i5"]
    done = [process(arm, read_motion(AUBO / day)) for day in DAYS]
    found = repeatability([one.alignment for one in done])
    assert found.gyro_scale <= 0.005
    assert np.degrees(found.mounting) <= 0.2
    assert np.degrees(found.gravity) <= 0.2
    for one in done:
        assert (one.measures.angular_velocity_error < 0.03 * one.measures.angular_velocity).all()
        assert np.degrees(one.measures.gravity_angle) < 0.1
