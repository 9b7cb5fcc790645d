"""The tracker's own noise in a band, from the band in which it sees nothing else."""

import numpy as np
import pytest

from armside.sim.gears.judgement import FLOOR_BAND, remaining

RATE = 100.0
"""[Hz], of aligned recordings."""


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
