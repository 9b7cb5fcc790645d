"""Servo inputs: the reference, and the correction after delay and lag."""

import numpy as np
import pytest

from armside.sim.robot.servo import correction_path, interpolate, substeps

PERIOD, RATIO = 0.004, 8
STEP = PERIOD / RATIO
DELAY, LAG = 0.013, 28.5


def _lagged(signal, delay=DELAY, lag=LAG):
    return correction_path(signal, PERIOD, RATIO, delay, lag)


def test_log_period_must_hold_whole_steps():
    assert substeps(0.0005, 0.004) == 8
    with pytest.raises(ValueError, match="not a multiple"):
        substeps(0.0005, 0.0043)


def test_interpolation_passes_through_the_samples_and_rests_at_the_ends():
    rng = np.random.default_rng(0)
    samples = np.cumsum(rng.standard_normal((60, 6)), axis=0)
    value, rate, _ = interpolate(samples, PERIOD, RATIO)
    assert np.abs(value[::RATIO] - samples).max() < 1e-12
    assert np.abs(rate[[0, -1]]).max() < 1e-9


def test_interpolation_differentiates_a_smooth_motion():
    t = np.arange(201) * PERIOD
    samples = np.sin(2 * np.pi * 1.25 * t)[:, None] ** 2  # at rest at both ends
    fine = np.arange(200 * RATIO + 1) * STEP
    _, rate, acceleration = interpolate(samples, PERIOD, RATIO)
    w = 2 * np.pi * 2.5  # sin^2 is a cosine of twice the frequency
    # a cubic spline errs by period^3 and period^2 times higher derivatives
    assert np.abs(rate[:, 0] - w / 2 * np.sin(w * fine)).max() < 0.01
    assert np.abs(acceleration[20:-20, 0] - w**2 / 2 * np.cos(w * fine[20:-20])).max() < 0.2


def test_a_correction_that_lasts_passes_unchanged():
    path = _lagged(np.full((100, 6), 0.3))
    assert path.position[-1] == pytest.approx(np.full(6, 0.3))
    assert path.velocity[-1] == pytest.approx(np.zeros(6), abs=1e-12)


def test_a_step_arrives_after_the_delay_and_rises_with_the_lag():
    signal = np.zeros((100, 1))
    signal[20:] = 1.0
    position = _lagged(signal, delay=DELAY).position[:, 0]
    # the first-order hold spreads the step over one log period before sample 20
    start = 19 * RATIO + round(DELAY / STEP)
    assert np.abs(position[: start + 1]).max() < 1e-15
    tau = 1.0 / (2 * np.pi * LAG)
    t = np.arange(len(position) - start) * STEP
    ramp = np.where(t < PERIOD, t - tau * (1 - np.exp(-t / tau)), 0.0) / PERIOD
    assert position[start : start + RATIO] == pytest.approx(ramp[:RATIO], abs=1e-12)


def test_lag_has_its_corner_frequency():
    t = np.arange(2000) * PERIOD
    signal = np.sin(2 * np.pi * 10.0 * t)[:, None]
    position = _lagged(signal, delay=0.0).position[:, 0]
    settled = position[len(position) // 2 :]
    gain = np.sqrt(2 * np.mean(settled**2))
    hold = np.sinc(10.0 * PERIOD) ** 2  # of the first-order hold
    assert gain == pytest.approx(hold / np.hypot(1.0, 10.0 / LAG), rel=1e-3)


def test_velocity_is_the_derivative_of_position():
    t = np.arange(400) * PERIOD
    path = _lagged(np.sin(2 * np.pi * 5.0 * t)[:, None])
    central = (path.position[2:] - path.position[:-2]) / (2 * STEP)
    # a bend of the input by dv at a sample makes the central difference miss 178 dv STEP / 4 there:
    # dv is (2 pi 5)^2 PERIOD = 4 /s between samples, and 31 /s where the sine begins
    miss = np.abs(central - path.velocity[1:-1])[:, 0]
    assert miss[len(miss) // 8 :].max() < 0.1
    assert miss.max() < 0.8
    assert np.abs(path.velocity).max() > 25.0
