"""Figures that an identification is scored by."""

import numpy as np
import pytest

from armside.sim.laser.identification import assigned, effective


def test_effective_stiffness_is_torque_over_deflection_with_all_springs_free():
    K = np.array([[4.0, 3.0], [3.0, 9.0]])
    for axis in range(2):
        deflection = np.linalg.solve(K, np.eye(2)[axis])
        assert effective(K)[axis] == pytest.approx(1.0 / deflection[axis])
    assert (effective(K) < np.diag(K)).all()
    assert effective(np.diag([4.0, 9.0])) == pytest.approx([4.0, 9.0])


def test_a_mode_counts_as_identified_within_a_tenth_and_once():
    true, found = np.array([7.2, 7.3, 11.9, 14.9]), np.array([7.2, 7.7, 14.7, 40.3, 55.0, 60.0])
    assert assigned(true, found) == [7.2, 7.7, None, 14.7]
    assert assigned(np.array([7.0, 7.1]), np.array([7.05])) in ([7.05, None], [None, 7.05])
    assert assigned(np.array([10.0]), np.array([11.1])) == [None]
