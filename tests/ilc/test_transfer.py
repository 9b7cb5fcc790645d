"""Derivatives of a reference."""

import numpy as np
import pytest

from armside.ilc.laws.transfer import LARGEST_ORDER, derivatives


@pytest.mark.parametrize("order", [1, LARGEST_ORDER])
def test_derivatives_of_a_parabola_are_its_slope_and_curvature_and_no_more(order):
    t = 0.01 * np.arange(60)
    found = derivatives((t**2)[:, None], 0.01, order)
    assert found.shape == (60, 1, order)
    expected = np.stack([2.0 * t, np.full(60, 2.0), *np.zeros((LARGEST_ORDER, 60))], axis=1)
    inside = slice(LARGEST_ORDER, -LARGEST_ORDER)  # differences at the ends are one-sided
    scale = 100.0 ** np.arange(1, order + 1)  # rounding of each difference over the sample time
    error = np.abs(found[inside, 0] - expected[inside, :order]) / scale
    assert error.max() < 1e-12


@pytest.mark.parametrize("order", [0, LARGEST_ORDER + 1])
def test_orders_beyond_are_refused(order):
    with pytest.raises(ValueError, match=f"1 to {LARGEST_ORDER}, got {order}"):
        derivatives(np.zeros((9, 1)), 0.01, order)
