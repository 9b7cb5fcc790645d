"""Bounds of the joint of chapter 8."""

import pytest

from armside.scripts.commands.reproduce import JointCfg


@pytest.mark.parametrize(
    ("name", "ends", "beyond"),
    [
        ("gamma", (1e-9, 100.0), (0.0, 100.1)),
        ("delta", (1, 100), (0, 101)),
        ("cutoff", (0.1, 49.0), (0.09, 49.1)),
    ],
)
def test_each_end_of_an_option_belongs_to_it_and_what_is_beyond_does_not(name, ends, beyond):
    for value in ends:
        assert getattr(JointCfg(**{name: value}), name) == value
    for value in beyond:
        with pytest.raises(ValueError, match=name):
            JointCfg(**{name: value})
