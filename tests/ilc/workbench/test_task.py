"""Corrections by their place on a path."""

import numpy as np

from armside.ilc.workbench.task import along_path


def test_a_correction_learned_at_rest_is_that_of_its_end_of_the_rest():
    """Before the path the last sample of the rest counts, on it the first."""
    correction, place = np.arange(1.0, 7.0)[:, None], np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    found = along_path(correction, place, np.array([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(found[:, 0], [2.0, 2.0, 2.5, 3.0, 5.0, 5.0])
