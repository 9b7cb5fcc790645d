"""Orders that are scanned."""

import numpy as np
import pytest

from armside.sim.gears.analysis import CANDIDATES, GearsCfg
from armside.sim.gears.fit import Normal, chosen
from armside.sim.gears.scan import COARSE, FINE, SMALLEST, Scan, grids, peaks


@pytest.mark.parametrize(("apart", "step"), [(2.0 * COARSE, FINE), (2.1 * COARSE, COARSE)])
def test_a_grid_goes_from_the_smallest_order_to_the_largest(apart, step):
    (grid,) = grids(np.array([apart]), 100.3)  # within half a step
    np.testing.assert_array_equal(grid, np.arange(SMALLEST, 101.0, step))


@pytest.mark.parametrize(
    ("strongest", "found"), [(1, [30.0]), (2, [30.0, 40.0]), (9, [30.0, 40.0, 50.0])]
)
def test_peaks_are_the_strongest_that_are_apart(strongest, found):
    orders, values = np.array([30.0, 32.0, 40.0, 50.0]), np.array([9.0, 8.0, 7.0, 1.0])
    one = Scan((orders,), (values,), (values,), 20.0)
    assert peaks(one, np.array([3.0]), strongest) == [(0, order) for order in found]


@pytest.mark.parametrize(("per_joint", "taken"), [(1, [1, 3]), (2, [1, 0, 3])])
def test_candidates_are_taken_by_what_they_explain_up_to_the_most_of_a_joint(per_joint, taken):
    """Of columns that are orthogonal; the third explains less than the floor."""
    y = np.array([2.0, 0.0, 3.0, 0.0, 0.1, 0.0, 1.0, 0.0])
    equations = Normal(np.eye(8), y, float(y @ y))
    candidates = [(0, 30.0), (0, 40.0), (1, 50.0), (1, 60.0)]
    assert chosen(equations, candidates, np.array([0.05, 0.05]), per_joint) == taken


def test_a_joint_has_from_one_term_to_all_candidates():
    for n in (1, CANDIDATES):
        assert GearsCfg(per_joint=n).per_joint == n
    for n in (0, CANDIDATES + 1):
        with pytest.raises(ValueError, match=f"per_joint must be 1 to {CANDIDATES}, got {n}"):
            GearsCfg(per_joint=n)
