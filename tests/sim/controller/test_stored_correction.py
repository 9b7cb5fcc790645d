"""What a stored correction commands."""

import numpy as np

from armside.sim.controller.stored_correction import StoredCorrection


def test_a_correction_is_added_to_its_reference():
    r, u = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[0.5, 0.0], [-0.25, 0.125]])
    stored = StoredCorrection(correction=u, reference=r, sample_time=0.01, k=1, robot=None)
    np.testing.assert_array_equal(stored.commanded, [[1.5, 2.0], [2.75, 4.125]])
