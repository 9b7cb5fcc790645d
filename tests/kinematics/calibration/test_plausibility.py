"""Measurements that lack what a calibration needs."""

import numpy as np
import pytest

from armside.kinematics.calibration.measurements import Measurements
from armside.kinematics.calibration.plausibility import _finite


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        ((slice(None), 1), np.nan, "target 2 was never seen"),
        ((3, 0, 2), np.nan, "target 1 in row 4 has some coordinates and lacks others"),
        ((3, 1, 2), np.inf, "a target has an infinite coordinate"),
    ],
)
def test_what_is_missing_is_named_with_its_target_and_row(place, value, said):
    points = np.ones((5, 2, 3))
    _finite(Measurements(phi=np.zeros((5, 6)), points=points))
    points[place] = value
    with pytest.raises(ValueError, match=said):
        _finite(Measurements(phi=np.zeros((5, 6)), points=points))
