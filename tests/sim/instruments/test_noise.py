"""Noise has the statistics it was asked for."""

import numpy as np
import pytest
from scipy.signal import welch

from armside.sim.instruments import noise

STEP = 5e-4


def test_white_noise_has_the_standard_deviation_of_each_channel():
    std = np.array([1.0, 2.0, 5.0])
    x = noise.white(np.random.default_rng(1), (100_000, 3), std)
    # Five standard errors of a standard deviation: 5 / sqrt(2 n).
    np.testing.assert_allclose(x.std(axis=0), std, rtol=5 / np.sqrt(2e5))


def test_a_density_is_what_a_spectrum_estimates():
    x = noise.from_density(np.random.default_rng(2), (200_000, 2), [0.1, 0.3], 100.0)
    f, power = welch(x, fs=100.0, nperseg=1000, axis=0)
    inner = (f > 1.0) & (f < 49.0)
    np.testing.assert_allclose(np.sqrt(power[inner].mean(axis=0)), [0.1, 0.3], rtol=0.02)


def test_band_limited_noise_is_stationary_from_the_first_sample():
    rng = np.random.default_rng(3)
    x = noise.band_limited(rng, (40, 20_000), 2.0, 20.0, STEP)
    np.testing.assert_allclose(x.std(axis=1), 2.0, rtol=5 / np.sqrt(4e4))


def test_band_limited_noise_halves_its_power_at_the_bandwidth():
    x = noise.band_limited(np.random.default_rng(4), (1_000_000, 1), 1.0, 50.0, STEP)[:, 0]
    f, power = welch(x, fs=1 / STEP, nperseg=4000)
    low = power[(f > 1) & (f < 6)].mean()
    at_bandwidth = power[(f > 48) & (f < 52)].mean()
    assert at_bandwidth / low == pytest.approx(0.5, rel=0.1)


def test_a_random_walk_spreads_with_the_square_root_of_time():
    x = noise.random_walk(np.random.default_rng(5), (1001, 5000), 0.3, 0.01)
    np.testing.assert_array_equal(x[0], 0.0)
    assert x[-1].std() == pytest.approx(0.3 * np.sqrt(10.0), rel=0.05)
    assert x[250].std() == pytest.approx(0.3 * np.sqrt(2.5), rel=0.05)


def test_a_bandwidth_that_is_not_positive_is_named():
    with pytest.raises(ValueError, match="bandwidth and step must be > 0"):
        noise.band_limited(np.random.default_rng(1), (10, 1), 1.0, 0.0, STEP)
