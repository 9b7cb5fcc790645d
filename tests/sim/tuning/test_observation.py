"""What the env shows of a run."""

import re

import numpy as np
import pytest

from armside.sim.tuning.env import IlcTuningEnv
from armside.sim.tuning.observation import BANDS, Layout, band_rms
from armside.sim.tuning.rules import Rules

SIX = Layout()
FEATURES, SIZE = SIX.features, SIX.size


def test_the_table_of_the_env_says_what_the_entries_are():
    row = r"^ +\| (\d+):(\d+) \| (.*) \| (\S+) \| (\S+) \| (\S+) \| (\w+) \|$"
    rows = re.findall(row, IlcTuningEnv.__doc__ or "", re.M)
    ends = np.cumsum([feature.size for feature in FEATURES]).tolist()
    assert [(int(a), int(b)) for a, b, *_ in rows] == list(zip([0, *ends[:-1]], ends, strict=True))
    for (_, _, name, unit, low, high, scale), feature in zip(rows, FEATURES, strict=True):
        assert (name, unit) == (feature.name, feature.unit)
        assert (float(low), float(high)) == (feature.low, feature.high)
        assert (scale == "log10") == feature.logarithmic
    space = Rules().observation_space
    assert space.shape == (SIZE,) == (ends[-1],)
    assert (space.low == -1).all()
    assert (space.high == 1).all()


@pytest.mark.parametrize("n", [401, 500])  # the second has Nyquist, and bins at the bands' ends
def test_band_energies_add_up_to_the_whole(n):
    signal = np.random.default_rng(0).standard_normal((n, 3))
    bands = band_rms(signal, 0.004, BANDS)
    assert np.sqrt((bands**2).sum(axis=0)) == pytest.approx(np.sqrt((signal**2).mean(axis=0)))


@pytest.mark.parametrize(("frequency", "band"), [(1.0, 0), (5.0, 1), (10.0, 2), (60.0, 3)])
def test_a_sine_lies_in_its_band(frequency, band):
    t = 0.004 * np.arange(500)  # whole periods
    rms = band_rms(np.sin(2 * np.pi * frequency * t)[:, None], 0.004, BANDS)[:, 0]
    assert rms[band] == pytest.approx(np.sqrt(0.5))
    assert np.delete(rms, band) == pytest.approx(0.0, abs=1e-12)


def test_features_are_scaled_clipped_and_never_nan():
    low, high, logarithmic = (
        np.array([getattr(f, name) for f in FEATURES for _ in range(f.size)])
        for name in ("low", "high", "logarithmic")
    )
    middle = np.where(logarithmic, np.sqrt(np.abs(low * high)), 0.5 * (low + high))
    tiny = np.where(logarithmic, 0.0, -1e9)
    wide = np.stack([low, middle, high, tiny, np.full(SIZE, 1e9), low * np.nan, high * np.inf])
    expected = np.array([-1.0, 0.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    assert SIX.normalised(wide) == pytest.approx(np.tile(expected[:, None], SIZE))
