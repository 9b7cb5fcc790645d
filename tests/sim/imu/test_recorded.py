"""Chapter 5 on recordings: a synthetic arm, and the AUBO i5."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside.kinematics import CATALOGUE
from armside.sim.imu.chapter5_recorded import mounting, process, repeatability, scale
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


def test_differences_between_recordings_are_those_of_their_constants(done):
    pair = [one.alignment for one in done]
    assert repeatability([pair[0], pair[0]]).mounting == 0.0
    moved = replace(pair[1], M_gyro=1.01 * pair[1].M_gyro)
    assert repeatability([pair[1], moved]).gyro_scale == pytest.approx(0.0102, abs=1e-4)
    assert repeatability(pair).mounting < np.radians(0.1)
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
