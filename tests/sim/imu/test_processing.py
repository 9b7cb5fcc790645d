"""Chapter 5's processing, on readings that are exact until an instrument makes them worse.

The robot is rigid here and moves by a formula, so measurement and prediction must agree to what
instruments and filters leave; with physics instead of a formula the same functions show elasticity.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from armside import kinematics
from armside.ilc import ZeroPhaseButterworth
from armside.kinematics import IRB1400_IMU
from armside.kinematics.rotation import from_axis_angle
from armside.sim.imu import (
    Compensation,
    Order,
    ProcessingCfg,
    Scheme,
    clock_offset,
    compensation,
    moving_rms,
    predict,
)
from armside.sim.imu.compensation import (
    GRAVITY,
    Calibration,
    calibrate,
    mean_removed,
    to_base,
    to_imu,
)
from armside.sim.imu.measured_beside_predicted import compare
from armside.sim.imu.predicted_motion import difference_quotients, resample
from armside.sim.instruments.encoder import quantise
from armside.sim.instruments.imu import ImuCfg, draw, exact

STEP, LOG, SECONDS = 5e-4, 0.004, 10.0
PERFECT = exact(ImuCfg()).cfg
BEST = ProcessingCfg(order=Order.MAP_THEN_FILTER, scheme=Scheme.CENTRAL)
SIZE = np.array([0.3, 0.25, 0.2, 0.5, 0.4, 0.5])
FREQUENCY = np.array([0.50, 0.63, 0.45, 0.80, 0.71, 0.55])  # Hz, so slow that 5 Hz passes it


def angles(time):
    """(M, 6) [rad]: all motors at once, smooth, at rest for the first and last second."""
    inside = np.clip((time - 1.0) / (SECONDS - 2.0), 0.0, 1.0)
    window = (np.sin(np.pi * inside) ** 4)[:, np.newaxis]
    return SIZE * window * np.sin(2 * np.pi * FREQUENCY * (time - 1.0)[:, np.newaxis])


@cache
def ideal():
    """Time, specific force and angular velocity in the IMU frame, every physics step."""
    time = np.arange(round(SECONDS / STEP) + 1, dtype=np.float64) * STEP
    h = 1e-4
    before, phi, after = angles(time - h), angles(time), angles(time + h)
    rate, acceleration = (after - before) / (2 * h), (after - 2 * phi + before) / h**2
    robot = kinematics.compile(IRB1400_IMU)
    R = robot.pose(phi)[:, :3, :3]
    a = robot.acceleration(phi, rate, acceleration)[:, :3]
    omega = np.einsum("kij,kj->ki", robot.jacobian(phi)[:, 3:], rate)
    return time, to_imu(R, a + GRAVITY), to_imu(R, omega)


def logged():
    """The motor log: quantised as in the thesis, 118 motor turns for one of the arm."""
    time = np.arange(round(SECONDS / LOG) + 1, dtype=np.float64) * LOG
    return time, quantise(angles(time), 4095, 118.0)


def run(cfg, seed=0, processing=None, **options):
    unit = draw(cfg, np.random.default_rng(seed))
    samples = unit.measure(*ideal(), np.random.default_rng(seed + 1000))
    return unit, compare(samples, *logged(), IRB1400_IMU, processing, **options)


def rms(error):
    return np.sqrt(np.mean(error**2))


def test_a_perfect_imu_and_the_motor_angles_agree():
    _, seen = run(PERFECT, processing=BEST)
    # The residual is encoder steps through the second difference; the motion is 5 m/s^2, 2 rad/s.
    assert np.ptp(seen.acceleration_measured) > 5.0
    assert rms(seen.acceleration_error) < 0.01
    assert rms(seen.angular_velocity_error) < 0.001


def test_gravity_is_that_of_the_place():
    time, force, rate = ideal()
    on_the_moon = np.array([0.0, 0.0, 1.62])
    R = kinematics.compile(IRB1400_IMU).pose(angles(time))[:, :3, :3]
    rng = np.random.default_rng(0)
    force = force + to_imu(R, np.tile(on_the_moon - GRAVITY, (len(R), 1)))
    samples = draw(PERFECT, rng).measure(time, force, rate, rng)
    there = compare(samples, *logged(), IRB1400_IMU, BEST, gravity=on_the_moon)
    assert rms(there.acceleration_error) < 0.01


def test_a_real_imu_agrees_within_its_noise_once_it_is_calibrated():
    for seed in range(3):
        _, seen = run(ImuCfg(), seed, BEST)
        # Noise of 0.012 m/s^2 and 0.012 rad/s through 5 Hz is a third of that; scale 3e-4 of 5.
        assert rms(seen.acceleration_error) < 0.015
        assert rms(seen.angular_velocity_error) < 0.006


def test_the_actual_orientation_compensates_better_than_the_mean_at_rest():
    def error(compensation, seed):
        # Forward differences would add an error of their own, half a sample of jerk, to both.
        processing = ProcessingCfg(compensation=compensation, scheme=Scheme.CENTRAL)
        _, seen = run(ImuCfg(), seed, processing)
        return rms(seen.acceleration_error)

    for seed in range(3):
        thesis = error(Compensation.MEAN_AT_REST, seed)
        assert error(Compensation.ACTUAL_ORIENTATION, seed) < 0.5 * thesis


def test_the_mean_at_rest_takes_a_bias_off_a_sensor_that_keeps_its_orientation():
    rest = np.arange(100) < 20
    signal = np.random.default_rng(0).normal(size=(100, 3)) + 5.0
    found = mean_removed(signal, rest)
    np.testing.assert_allclose(found[rest].mean(axis=0), 0.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.diff(found, axis=0), np.diff(signal, axis=0), rtol=0, atol=1e-14)
    with pytest.raises(ValueError, match="none"):
        mean_removed(signal, np.zeros(100, dtype=bool))


def test_forward_differences_do_not_pass_for_a_tilt_of_the_sensor():
    # They are half a sample early; if the fit of the mounting saw them, the tilt it found would
    # put 0.02 m/s^2 of gravity into the acceleration.
    _, seen = run(ImuCfg(), 0, ProcessingCfg(scheme=Scheme.FORWARD))
    assert rms(seen.acceleration_error) < 0.015


def test_filtering_joint_rates_before_the_map_costs_what_filtering_after_does_not():
    def error(order):
        processing = ProcessingCfg(order=order, scheme=Scheme.CENTRAL, cutoff=2.0)
        return rms(run(PERFECT, processing=processing)[1].angular_velocity_error)

    assert error(Order.MAP_THEN_FILTER) < 0.2 * error(Order.FILTER_THEN_MAP)


def test_a_delay_that_is_not_compensated_costs_jerk_and_rotating_gravity():
    processing = replace(BEST, compensation=Compensation.MEAN_AT_REST)
    _, right = run(PERFECT, processing=processing, offset=0.0)
    _, late = run(PERFECT, processing=replace(processing, accelerometer_delay=0.0), offset=0.0)
    jerk = np.gradient(right.acceleration_measured, 0.01, axis=0)
    # The late reading is rotated to base by an orientation that has moved on: omega x (a + g).
    force = right.acceleration_measured + GRAVITY
    turning = np.cross(right.angular_velocity_measured, force)
    expected = PERFECT.accelerometer.delay * rms(jerk - turning)
    assert rms(late.acceleration_error) == pytest.approx(expected, rel=0.02)
    assert rms(turning) > rms(jerk)


def test_the_clock_offset_is_found_over_20_seeds():
    errors = []
    for seed in range(20):
        unit, seen = run(replace(ImuCfg(), clock_offset=0.4), seed)
        errors.append(seen.clock_offset - unit.clock_offset)
    assert np.std(errors) < 0.3e-3
    assert np.max(np.abs(errors)) < 1e-3


def test_a_clock_offset_beyond_the_search_is_an_error():
    unit = replace(draw(PERFECT, np.random.default_rng(0)), clock_offset=1.0)
    samples = unit.measure(*ideal(), np.random.default_rng(1))
    with pytest.raises(ValueError, match="search further"):
        compare(samples, *logged(), IRB1400_IMU, ProcessingCfg(search=0.2))


def test_clocks_of_a_robot_that_stands_still_cannot_be_synchronised():
    t = np.arange(100, dtype=np.float64) * 0.01
    gyro = np.random.default_rng(0).normal(size=(100, 3))
    with pytest.raises(ValueError, match="does not rotate"):
        clock_offset(t, gyro, t, np.zeros((100, 3)))


def test_calibration_finds_mounting_and_biases_of_a_sensor_that_rotates(monkeypatch):
    rng = np.random.default_rng(5)
    truth = Calibration(
        R_site_imu=from_axis_angle([1.0, -2.0, 0.5], np.deg2rad(2.0)),
        accelerometer_bias=np.array([0.02, -0.03, 0.01]),
        gyroscope_bias=np.array([0.01, 0.0, -0.02]),
    )
    force, rate = 9.82 * rng.normal(size=(500, 3)), rng.normal(size=(500, 3))
    readings = (
        force @ truth.R_site_imu + truth.accelerometer_bias,
        rate @ truth.R_site_imu + truth.gyroscope_bias,
    )
    for name in ("ACCELERATION", "ANGULAR_VELOCITY"):
        monkeypatch.setattr(compensation, name, 1e-4)
    found = calibrate(*readings, force, rate)
    # The prior pulls by (reading / prior)^2 / samples of the value: below 1e-6.
    np.testing.assert_allclose(found.R_site_imu, truth.R_site_imu, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.accelerometer_bias, truth.accelerometer_bias, atol=1e-6)
    np.testing.assert_allclose(found.gyroscope_bias, truth.gyroscope_bias, rtol=0, atol=1e-6)
    a, omega = found.corrected(*readings)
    np.testing.assert_allclose(a, force, rtol=0, atol=1e-4)
    np.testing.assert_allclose(omega, rate, rtol=0, atol=1e-5)


def test_difference_quotients_are_those_of_the_thesis():
    h = 0.01
    t = np.arange(50, dtype=np.float64)[:, np.newaxis] * h
    phi = np.hstack([t**2, 3 * t])
    forward, second = difference_quotients(phi, h, Scheme.FORWARD)
    central, _ = difference_quotients(phi, h, Scheme.CENTRAL)
    np.testing.assert_allclose(forward[1:-1, 0], (2 * t + h)[1:-1, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(central[1:-1, 0], 2 * t[1:-1, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(second[1:-1], np.tile([2.0, 0.0], (48, 1)), rtol=0, atol=1e-10)


def test_resampling_keeps_samples_and_holds_the_ends():
    time, phi = logged()
    np.testing.assert_allclose(resample(time, phi, time), phi, rtol=0, atol=1e-15)
    held = resample(time, phi, np.array([-1.0, SECONDS + 1.0]))
    np.testing.assert_allclose(held, phi[[0, -1]], rtol=0, atol=1e-15)


def test_rotation_to_base_and_back_is_the_identity():
    R = from_axis_angle(np.random.default_rng(0).normal(size=(20, 3)), np.linspace(0, 3, 20))
    v = np.random.default_rng(1).normal(size=(20, 3))
    np.testing.assert_allclose(to_imu(R, to_base(R, v)), v, rtol=0, atol=1e-14)


def test_at_rest_nothing_is_predicted():
    phi = np.tile(SIZE, (200, 1))
    still = predict(IRB1400_IMU, phi, 0.01, ZeroPhaseButterworth(5.0, 0.01))
    np.testing.assert_allclose(still.angular_velocity, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(still.acceleration, 0.0, rtol=0, atol=1e-10)


def test_the_moving_rms_of_a_constant_is_the_constant_and_sees_only_its_window():
    error = np.full((100, 2), [2.0, 3.0])
    np.testing.assert_allclose(moving_rms(error, 0.5, 0.01), error, rtol=1e-12)
    burst = np.zeros((300, 1))
    burst[150] = 1.0
    seen = np.flatnonzero(moving_rms(burst, 0.5, 0.01)[:, 0] > 1e-6)
    assert (seen[0], seen[-1]) == (125, 175)


@pytest.mark.parametrize("name", ["accelerometer_delay", "gyroscope_delay"])
@pytest.mark.parametrize("delay", [-1e-3, 0.6, 1e305, np.nan, np.inf])
def test_a_delay_beyond_the_search_of_the_clock_is_refused(name, delay):
    with pytest.raises(ValueError, match=f"{name} must be from 0 to 500 ms"):
        ProcessingCfg(**{name: delay})


def test_a_bias_is_drawn_to_zero_by_its_prior_as_the_mean_of_gaussians():
    """Readings at rest without gravity say nothing of the mounting: b = r K/s^2 (K/s^2 + 1/p^2)^-1
    for K readings r of deviation s and a prior p."""
    zero, reading = np.zeros((5, 3)), np.array([0.01, -0.02, 0.005])
    found = calibrate(zero, zero + reading, zero, zero)
    told = 5.0 / compensation.ANGULAR_VELOCITY**2
    expected = reading * told / (told + compensation.GYROSCOPE_BIAS**-2)
    np.testing.assert_allclose(found.gyroscope_bias, expected, rtol=1e-9)
    np.testing.assert_allclose(found.accelerometer_bias, 0.0, atol=1e-15)
