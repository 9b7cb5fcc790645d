"""Evaluation of IMU records on made-up samples: what is counted, and from when."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from armside.sim.imu import ImuExperiment, RestExperiment, run_rest
from armside.sim.imu.compensation import GRAVITY, calibrate
from armside.sim.imu.imu_experiment import sense
from armside.sim.imu.phases import Evaluation, ImuRun, measure
from armside.sim.imu.vibration import at_rest, power_spectrum
from armside.sim.instruments.imu import ImuCfg, ImuSamples, draw
from armside.sim.robot.virtual_robot import VirtualRobot

RATE = 100.0


def samples(acceleration):
    time = np.arange(len(acceleration)) / RATE
    zero = np.zeros_like(acceleration)
    return ImuSamples(
        time=time,
        acceleration=acceleration,
        angular_velocity=zero,
        acceleration_clipped=zero.astype(bool),
        angular_velocity_clipped=zero.astype(bool),
    )


def test_vibration_is_that_about_the_mean_before_and_half_a_second_after_switching_on():
    rng, n = np.random.default_rng(0), 2000
    a = rng.standard_normal((n, 3)) * [0.01, 0.02, 0.03] + [0.1, -0.2, 9.82]
    t = np.arange(n) / RATE
    on = t >= 8.0
    a[on] += 0.3 * rng.standard_normal((on.sum(), 3))
    transient = (t >= 8.0) & (t < 8.5)
    a[transient] += 50.0
    rest = at_rest(samples(a), 8.0, RATE)
    assert rest.off_rms == pytest.approx(a[t < 8.0].std(axis=0))
    steady = a[t >= 8.5]
    assert rest.on_rms == pytest.approx(steady.std(axis=0))
    # the level that three samples of a thousand exceed
    apart = np.abs(steady - steady.mean(axis=0))
    assert (apart > rest.on_level).mean(axis=0) == pytest.approx(np.full(3, 0.003), abs=1e-3)
    assert rest.on_spectrum == pytest.approx(power_spectrum(steady, RATE)[1])


def test_a_spectrum_has_the_power_of_its_signal():
    """Parseval: the integral of the one-sided density is the variance."""
    signal = np.random.default_rng(1).standard_normal((20_000, 2)) * [1.0, 3.0]
    frequency, density = power_spectrum(signal, RATE)
    power = density.sum(axis=0) * (frequency[1] - frequency[0])
    assert power == pytest.approx(signal.var(axis=0), rel=0.05)


def test_specific_force_at_rest_is_the_gravity_of_the_physics():
    """Thesis (5.2); what the processing subtracts is what the model has."""
    assert pytest.approx([0.0, 0.0, 9.82]) == GRAVITY
    option = ImuExperiment().model().mj.opt
    assert pytest.approx(-option.gravity) == GRAVITY


def test_robot_and_imu_have_streams_of_their_own_from_the_seed():
    """Another IMU leaves the robot's motion as it is; another seed changes both."""
    experiment = RestExperiment(off=3.0, on=3.0)
    still = np.zeros((120, 6))
    loaded = VirtualRobot(experiment.model()).load(still)
    first, again, other = (sense(loaded, experiment.imu, seed) for seed in (0, 0, 1))
    assert np.array_equal(first.samples.acceleration, again.samples.acceleration)
    assert np.array_equal(first.recording.motor_angle, again.recording.motor_angle)
    assert (first.imu.accelerometer.bias != other.imu.accelerometer.bias).all()
    angle = first.recording.truth.gear_angle
    assert (angle[-1] != other.recording.truth.gear_angle[-1]).any()
    noisier = replace(ImuCfg(), mounting_error=0.1)
    changed = sense(loaded, noisier, 0)
    assert np.array_equal(changed.recording.motor_angle, first.recording.motor_angle)
    # the unit is drawn from the second stream of the seed, before anything else
    stream = np.random.SeedSequence(0).spawn(2)[1]
    unit = draw(experiment.imu, np.random.default_rng(stream))
    assert np.array_equal(first.imu.gyroscope.bias, unit.gyroscope.bias)


@pytest.fixture
def evaluated():
    """A comparison of 400 samples, quiet but for its first quarter, and its run."""
    rng = np.random.default_rng(2)
    t = np.arange(400) / RATE
    error = 0.1 * rng.standard_normal((400, 3))
    error[t < 1.0] += 5.0
    comparison = SimpleNamespace(
        time=t,
        angular_velocity_error=0.1 * error,
        acceleration_error=error,
        acceleration_measured=2.0 * error,
        clock_offset=0.012,
    )
    tool, off = rng.standard_normal((50, 3)), np.array([0.0, 3e-3, 4e-3])
    return comparison, Evaluation(comparison, np.abs(error), tool, tool + off)


def test_measures_begin_where_the_synchronisation_ends(evaluated, monkeypatch):
    from armside.sim.imu import phases as room

    comparison, evaluation = evaluated
    monkeypatch.setattr(room, "largest_gap", lambda *_: 0.0)
    monkeypatch.setattr(room, "idle_peaks", lambda _: np.zeros(6))
    a = np.zeros((400, 3))
    read = samples(a)
    read.acceleration_clipped[:8, 1] = True
    run = ImuRun(recording=None, samples=read, imu=SimpleNamespace(clock_offset=0.010))
    late = comparison.time >= 1.0
    found = measure(run, evaluation, None, since=1.0)
    error = comparison.acceleration_error[late]
    assert found.acceleration_rms == pytest.approx(np.sqrt(np.mean(error**2, axis=0)))
    assert found.angular_velocity_rms == pytest.approx(0.1 * found.acceleration_rms)
    assert found.angular_velocity_max == pytest.approx(0.1 * np.abs(error).max(axis=0))
    assert found.acceleration_window_max == pytest.approx(np.abs(error).max(axis=0))
    where = comparison.time[late][np.abs(error).argmax(axis=0)]
    assert found.acceleration_window_time == pytest.approx(where)
    assert found.acceleration_peak == pytest.approx(2 * np.abs(error).max(axis=0))
    assert found.clock_offset_error == pytest.approx(0.002)
    assert found.tool_distance == pytest.approx(5e-3)
    assert found.clipped_share == pytest.approx(8 / 400)
    assert found.since == 1.0


def test_same_seed_same_rest_and_another_seed_another():
    experiment = RestExperiment(off=3.0, on=3.0)
    first, again, other = (run_rest(experiment, seed).rest for seed in (5, 5, 6))
    assert np.array_equal(first.on_rms, again.on_rms)
    assert (first.on_rms != other.on_rms).all()


@pytest.mark.parametrize("offset", [0.05, -0.05])
def test_an_offset_of_a_sensor_that_never_rotates_is_divided_as_the_prior_says(offset):
    """Tilt of 1 deg leaks 0.171 m/s^2 of gravity, the bias is 0.02 m/s^2: both one sigma."""
    n = 4000
    force = np.tile([0.0, 0.0, 9.82], (n, 1))
    reading, rate = force + np.array([offset, 0.0, 0.0]), np.zeros((n, 3))
    found = calibrate(reading, rate, force, rate)
    leak, bias = 9.82 * np.deg2rad(1.0), 0.02
    expected = offset * bias**2 / (bias**2 + leak**2)
    assert found.accelerometer_bias[0] == pytest.approx(expected, rel=0.02)
    leaked = found.R_site_imu.T @ force[0]
    assert leaked[0] == pytest.approx(offset - expected, rel=0.02)
