"""Limits of options at their very ends."""

import pytest

from armside.scripts.shell.options import Limits


@pytest.mark.parametrize(
    ("limits", "given", "allowed"),
    [
        (Limits(1.0, 2.0), (1.0, 2.0), True),
        (Limits(1.0, 2.0), (1.5, 2.1), False),
        (Limits(1.0, 2.0), 0.9, False),
        (Limits(1.0, 2.0, above=True), 1.0, False),
        (Limits(1.0, 2.0, above=True), 2.0, True),
        (Limits(1.0, 2.0, below=True), 2.0, False),
        (Limits(1.0, 2.0, below=True), 1.0, True),
        (Limits(1.0), None, True),
    ],
)
def test_an_end_belongs_to_the_range_unless_it_is_said_not_to(limits, given, allowed):
    if allowed:
        limits.check("width", given)
    else:
        with pytest.raises(ValueError, match=r"^width must be "):
            limits.check("width", given)
