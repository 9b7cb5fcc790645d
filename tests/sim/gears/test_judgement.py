"""Estimates of the tool's error in bands of frequency, on signals whose parts are known."""

import numpy as np
import pytest

from armside.sim.gears.judgement import FLOOR_BAND, in_bands, remaining, spectra
from armside.sim.recordings.alignment.encoder_motion import RATE

AMPLITUDE, NOISE = 50e-6, 5e-6
"""[m] Of a sine of 6 Hz along x, and standard deviation of the tracker's white noise per axis."""


@pytest.fixture(scope="module")
def signals():
    t = np.arange(0.0, 80.0, 1.0 / RATE)
    sine = np.outer(AMPLITUDE * np.sin(12.0 * np.pi * t), [1.0, 0.0, 0.0])
    noise = NOISE * np.random.default_rng(0).normal(size=sine.shape)
    return sine, noise, np.abs(t - 40.0) < 35.0


def test_ratio_is_what_each_estimate_leaves_and_the_floor_is_the_noise(signals):
    sine, noise, rows = signals
    found = in_bands(sine + noise, 0.5 * sine, sine, rows)
    (band,) = (one for one in found if one.band == (4.0, 8.0))
    # White noise spreads over 0 to 50 Hz; the band has 4 of them
    expected = NOISE * np.sqrt(3.0 * 4.0 / 50.0)
    assert band.floor == pytest.approx(expected, rel=0.1)
    assert band.rms == pytest.approx(AMPLITUDE / np.sqrt(2.0), rel=0.02)
    assert band.gears == pytest.approx(0.5, abs=0.02)
    assert band.fused == pytest.approx(expected / band.rms, rel=0.15)
    assert band.fused is not None
    assert band.beyond_floor(band.fused) < 0.04
    assert band.beyond_floor(1.0) == pytest.approx(1.0)


def test_other_bands_hold_the_noise_alone(signals):
    sine, noise, rows = signals
    found = in_bands(sine + noise, sine, None, rows)
    for band in (found[0], found[-1]):
        assert band.rms == pytest.approx(band.floor, rel=0.2)
        assert band.gears == pytest.approx(1.0, abs=0.02)
        assert band.fused is None


def test_spectra_hold_the_energy_of_the_signal(signals):
    sine, noise, rows = signals
    found = spectra(sine + noise, sine, None, rows)
    step = found.frequency[1]
    energy = [np.sum(x**2) * step for x in (found.encoders, found.gears)]
    assert energy[0] == pytest.approx(AMPLITUDE**2 / 2.0 + 3.0 * NOISE**2, rel=0.05)
    assert energy[1] == pytest.approx(3.0 * NOISE**2, rel=0.05)
    assert found.fused is None


@pytest.mark.parametrize("band", [(2.0, 4.0), (4.0, 8.0), (12.0, 16.0), FLOOR_BAND])
def test_the_floor_of_white_noise_is_its_rms_in_the_band(band):
    """An amplitude grows with the root of the band's width. 20,000 samples: 2 % scatter."""
    noise = 1e-5 * np.random.default_rng(0).standard_normal((20_000, 3))
    rows = np.ones(len(noise), dtype=bool)
    left = remaining(noise, np.zeros_like(noise), rows, band)
    np.testing.assert_allclose(left.floor, left.rms, rtol=0.1)
    assert left.pooled == 1.0


def test_what_a_model_leaves_is_stated_by_axis_and_for_all():
    """Sines of 6 Hz in white noise, of which a model knows half, nothing and all."""
    time, size = np.arange(20_000) / RATE, np.array([3e-5, 2e-5, 1e-5])
    noise = 1e-6 * np.random.default_rng(0).standard_normal((len(time), 3))
    sine = size * np.sin(2 * np.pi * 6.0 * time)[:, np.newaxis]
    rows = np.arange(len(time)) >= 100
    left = remaining(sine + noise, [0.5, 0.0, 1.0] * sine, rows, (4.0, 8.0))
    np.testing.assert_allclose(left.rms, size / np.sqrt(2.0), rtol=0.02)
    floor = 1e-6 * np.sqrt(4.0 / 50.0)  # of 0 to 50 Hz
    np.testing.assert_allclose(left.floor, floor, rtol=0.1)
    np.testing.assert_allclose(left.ratio[:2], [0.5, 1.0], atol=0.01)
    assert left.ratio[2] == pytest.approx(floor / left.rms[2], rel=0.2)
    pooled = np.sqrt((1.5e-5**2 + 2e-5**2) / np.sum(size**2))
    assert left.pooled == pytest.approx(pooled, rel=0.01)
