"""Whose correction a motion may take."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.sim.part.motion import SAME, follows

LINE, SHORTER = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([[0.0, 0, 0]])


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ([LINE], False),
        ([LINE, LINE, LINE], False),
        ([LINE, SHORTER], False),
        ([LINE, LINE + 0.9 * SAME], True),
        ([LINE, LINE + 1.1 * SAME], False),
    ],
)
def test_contours_are_the_same_in_number_points_and_place(other, same):
    before, motion = (SimpleNamespace(outline=outline) for outline in ([LINE, LINE], other))
    assert follows(before, motion, anywhere=True) == same
