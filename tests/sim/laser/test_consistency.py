"""Directions in which an estimate of the tool is scored."""

import numpy as np
import pytest

from armside.sim.laser.estimate_consistency import directions


def test_a_tool_is_scored_in_the_directions_in_which_it_moves():
    plane = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    moving = directions(plane)
    assert moving.shape == (3, 2)
    assert moving[2] == pytest.approx(np.zeros(2), abs=1e-12)
    assert np.array_equal(directions(np.eye(3)), np.eye(3))


@pytest.mark.parametrize(("part", "moving"), [(0.5, 2), (2.0, 3)])
def test_a_direction_is_immovable_below_a_billionth_of_the_one_that_moves_most(part, moving):
    assert directions(np.diag([2.0, 1.0, 2.0 * part * 1e-9])).shape == (3, moving)
