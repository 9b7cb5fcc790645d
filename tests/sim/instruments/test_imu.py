"""The IMU's errors have the sizes configured, and its clock is its own."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.instruments.imu import ImuCfg, Triad, draw, exact

STEP = 5e-4
CLEAN = exact(ImuCfg()).cfg
PERFECT = CLEAN.accelerometer


def rng(seed=0):
    return np.random.default_rng(seed)


def record(seconds):
    return np.arange(round(seconds / STEP) + 1) * STEP


def still(cfg, seconds, seed=0):
    """Readings at rest, and the unit that made them."""
    unit, time = draw(cfg, rng(seed)), record(seconds)
    force = np.tile([0.0, 0.0, 9.82], (len(time), 1))
    return unit, unit.measure(time, force, np.zeros_like(force), rng(seed + 1000))


def test_a_triad_reads_its_sensitivity_times_the_input_plus_its_bias():
    S = np.array([[1.01, 0.02, 0.0], [0.0, 0.99, 0.03], [-0.01, 0.0, 1.0]])
    bias = np.array([0.1, -0.2, 0.3])
    unit = draw(CLEAN, rng())
    unit = replace(unit, accelerometer=Triad(cfg=PERFECT, sensitivity=S, bias=bias))
    time = record(0.2)
    force = np.tile([1.0, 2.0, 9.82], (len(time), 1))
    samples = unit.measure(time, force, 0 * force, rng())
    np.testing.assert_allclose(samples.acceleration[5], S @ force[0] + bias, rtol=0, atol=1e-12)


def test_a_mounting_error_is_a_rotation_that_leaks_gravity():
    unit, samples = still(replace(CLEAN, mounting_error=np.deg2rad(0.5)), 0.5)
    R = unit.R_site_imu
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=1e-15)
    expected = R.T @ [0.0, 0.0, 9.82]
    np.testing.assert_allclose(samples.acceleration[10], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("kind", "bandwidth"), [("acceleration", 30.0), ("angular_velocity", 40.0)]
)
def test_a_slow_signal_comes_out_late_by_the_known_delay(kind, bandwidth):
    time = record(4.0)
    slow = np.tile(np.sin(2 * np.pi * 1.0 * time)[:, np.newaxis], (1, 3))
    samples = draw(CLEAN, rng()).measure(time, slow, slow, rng())
    t, y = samples.time[100:-100], getattr(samples, kind)[100:-100, 0]
    turn = np.exp(-2j * np.pi * t)
    phase = np.angle(turn @ y) - np.angle(turn @ np.sin(2 * np.pi * t))
    delay = -phase / (2 * np.pi)
    assert delay == pytest.approx(np.sqrt(2) / (2 * np.pi * bandwidth), rel=0.01)
    assert replace(PERFECT, bandwidth=bandwidth).delay == pytest.approx(delay, rel=0.01)


def test_a_signal_at_the_corner_frequency_loses_half_its_power():
    time = record(4.0)
    fast = np.tile(np.sin(2 * np.pi * 30.0 * time)[:, np.newaxis], (1, 3))
    samples = draw(replace(CLEAN, rate=1000.0), rng()).measure(time, fast, fast, rng())
    power = samples.acceleration[1000:3000, 0].var() / 0.5
    assert power == pytest.approx(0.5, rel=0.01)


def test_readings_beyond_the_range_are_clipped_and_flagged():
    time = record(2.0)
    force = np.zeros((len(time), 3))
    force[:, 2] = 9.82 + 10.0 * np.sin(2 * np.pi * time)
    samples = draw(CLEAN, rng()).measure(time, force, 0 * force, rng())
    z, flagged = samples.acceleration[:, 2], samples.acceleration_clipped[:, 2]
    assert z.max() == 17.0
    assert np.all(z[flagged] == 17.0)
    assert np.all(z[~flagged] < 17.0)
    assert 0.1 < flagged.mean() < 0.35
    assert not samples.acceleration_clipped[:, :2].any()
    assert not samples.angular_velocity_clipped.any()


def test_the_clock_has_its_own_zero_and_pace():
    unit = replace(draw(CLEAN, rng()), clock_offset=0.1234, clock_drift=1e-3)
    time = record(5.0)
    ramp = np.tile(time[:, np.newaxis], (1, 3))
    samples = unit.measure(time, ramp, ramp, rng())
    np.testing.assert_allclose(np.diff(samples.time), 0.01, rtol=0, atol=1e-12)
    robot_time = 0.1234 + 1.001 * samples.time
    assert robot_time.min() >= 0.0
    assert robot_time.max() <= 5.0
    # A ramp is delayed by the low-pass and otherwise shows the time itself.
    late = robot_time - samples.acceleration[:, 0]
    np.testing.assert_allclose(late[50:], PERFECT.delay, rtol=0, atol=1e-5)


def test_the_same_seed_gives_the_same_bits_and_another_does_not():
    _, a = still(ImuCfg(), 1.0, seed=3)
    _, b = still(ImuCfg(), 1.0, seed=3)
    _, c = still(ImuCfg(), 1.0, seed=4)
    np.testing.assert_array_equal(a.acceleration, b.acceleration)
    assert np.any(a.acceleration[:50] != c.acceleration[:50])


@pytest.mark.parametrize(
    ("cfg", "change", "message"),
    [
        (CLEAN, {"rate": 0.0}, "rate must be > 0"),
        (CLEAN, {"mounting_error": -1.0}, "mounting_error must be >= 0"),
        (CLEAN, {"clock_offset": np.nan}, "clock_offset must be >= 0"),
        (PERFECT, {"range": 0.0}, "range must be > 0"),
        (PERFECT, {"noise_density": -1.0}, "noise_density must be >= 0"),
    ],
)
def test_a_configuration_checks_itself(cfg, change, message):
    with pytest.raises(ValueError, match=message):
        replace(cfg, **change)
