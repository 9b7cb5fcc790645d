"""Turns of recorded data check themselves."""

import numpy as np
import pytest

from armside.sim.evaluation.recorded import CircleTurn


@pytest.mark.parametrize(("start", "end"), [(1.0, 0.0), (1.0, 1.0), (np.nan, 1.0)])
def test_a_turn_that_ends_before_it_starts_is_refused(start, end):
    with pytest.raises(ValueError, match="start must be before end"):
        CircleTurn(radius=0.005, start=start, end=end)
