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
