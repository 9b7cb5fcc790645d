"""Intervals of a fraction."""

import pytest
from scipy.stats import binom

from armside.ilc.analysis.robustness import fraction_interval


@pytest.mark.parametrize(("held", "n"), [(0, 5), (5, 5), (3, 5), (1, 1), (19, 20)])
def test_at_each_end_of_an_interval_what_was_seen_has_half_of_the_rest_as_its_probability(held, n):
    """Clopper and Pearson's definition, by sums of the binomial distribution."""
    low, high = fraction_interval(held, n, 0.9)
    assert low == 0.0 if held == 0 else binom.sf(held - 1, n, low) == pytest.approx(0.05)
    assert high == 1.0 if held == n else binom.cdf(held, n, high) == pytest.approx(0.05)


@pytest.mark.parametrize(("held", "n"), [(-1, 5), (6, 5), (0, 0)])
def test_counts_that_cannot_be_are_refused(held, n):
    with pytest.raises(ValueError, match=f"got {held} of {n}"):
        fraction_interval(held, n)
