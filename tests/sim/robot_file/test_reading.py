"""Counts of numbers that a key of a robot file takes."""

import pytest

from armside.sim.robot_file.hardware import DRIVES
from armside.sim.robot_file.reading import _numbers


@pytest.mark.parametrize(("n_axes", "or_one"), [(1, ""), (2, " or one number")])
def test_a_key_of_each_axis_may_be_one_number_for_all(n_axes, or_one):
    key, given = DRIVES["gear_ratio"], [100.0] * (n_axes + 1)
    with pytest.raises(ValueError, match=f"must have {n_axes} numbers{or_one}, got {n_axes + 1}"):
        _numbers("drives: gear_ratio", given, key, n_axes)
    assert _numbers("drives: gear_ratio", 100.0, key, n_axes) == (100.0,) * n_axes
