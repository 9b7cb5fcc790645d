"""Which verdicts fail, and where a band ends."""

from dataclasses import replace

import numpy as np
import pytest

CLOSE = 1e-3
"""Relative distance of a fed value from its bar."""


def failing(table):
    return [v.statement for v in table.verdicts if not v.holds]


def fails_by_itself(found, words):
    """One statement fails, the one with these words."""
    assert len(found) == 1, found
    assert words in found[0], found


def assert_band(check, low, high):
    """The ends of a check, and its verdict on both sides of each."""
    # ends of a computed band are sums: equal to rounding
    assert (check.low is None, check.high is None) == (low is None, high is None), check.id
    for end, stated, outwards in ((check.low, low, -1.0), (check.high, high, 1.0)):
        if end is None:
            continue
        assert end == pytest.approx(stated, rel=1e-12, abs=1e-15), check.id
        assert replace(check, ours=end).holds, check.id
        beyond = np.nextafter(end, outwards * np.inf)
        assert not replace(check, ours=beyond).holds, check.id
