"""Magnification of a path."""

from types import SimpleNamespace

import pytest

from armside.sim.replay.paths import fitting_magnification


@pytest.mark.parametrize(
    ("worst", "factor"),
    [(0.015, 50), (0.016, 20), (0.0376, 10), (0.076, 5), (0.151, 2), (0.375, 2), (0.376, 1)],
)
def test_the_largest_magnified_deviation_is_at_most_three_quarters_of_the_half_size(worst, factor):
    contour = SimpleNamespace(is_part=False, worst=worst, half_size=1.0)
    assert fitting_magnification([contour]) == factor
