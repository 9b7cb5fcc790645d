"""Sizes of a test correction."""

import pytest

from armside.ilc.laws.model_free import MeasuredGradient


@pytest.mark.parametrize("size", [0.0, -1.0, float("nan"), float("inf")])
def test_a_test_correction_has_a_size_above_zero(size):
    with pytest.raises(ValueError, match=f"size must be > 0, got {size}"):
        MeasuredGradient(experiment=lambda u: u, size=size)
