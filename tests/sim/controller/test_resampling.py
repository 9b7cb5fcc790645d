"""A signal at another rate: samples kept where they can be, no band folded back."""

import numpy as np
import pytest

from armside.sim.controller.correction_export import resampled

T = 0.004
TIME = np.arange(501) * T


def sine(frequency):
    return np.sin(2.0 * np.pi * frequency * TIME)[:, np.newaxis]


def test_the_same_rate_keeps_every_bit():
    values = sine(7.0)
    assert resampled(values, T, 250.0) is values


def test_a_multiple_of_the_rate_passes_through_every_sample():
    values = sine(7.0)
    np.testing.assert_allclose(resampled(values, T, 1000.0)[::4], values, rtol=0, atol=1e-12)


@pytest.mark.parametrize("rate", [100.0, 123.0, 333.0, 1000.0])
def test_a_slow_signal_is_itself_at_any_rate(rate):
    found = resampled(sine(2.0), T, rate)
    time = np.arange(len(found)) / rate
    inside = (time > 0.2) & (time < 1.8)
    wanted = np.sin(2.0 * np.pi * 2.0 * time)
    np.testing.assert_allclose(found[inside, 0], wanted[inside], rtol=0, atol=2e-3)


def test_what_a_lower_rate_cannot_hold_is_removed_and_not_folded_back():
    """90 Hz at 50 Hz would be 10 Hz; what is left of it is the low-pass's gain at 90 Hz."""
    found = resampled(sine(90.0), T, 50.0)
    assert np.abs(found[10:-10]).max() < 2e-3


def test_the_end_is_reached_and_held():
    values = np.linspace(0.0, 1.0, 501)[:, np.newaxis]
    found = resampled(values, T, 300.0)
    assert found[-1, 0] == pytest.approx(1.0, abs=1e-9)
    assert (len(found) - 1) / 300.0 >= 500 * T


@pytest.mark.parametrize("rate", [0.5, 1e5, np.nan])
def test_a_rate_out_of_range_is_refused(rate):
    with pytest.raises(ValueError, match="rate must be 1 to 20000 Hz"):
        resampled(sine(1.0), T, rate)
