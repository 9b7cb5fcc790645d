"""What is known of an individual before any cut."""

import numpy as np
import pytest

from armside.sim.twin.parameters import FRICTION, MASS


@pytest.mark.parametrize("block", [*FRICTION, MASS], ids=lambda block: block.name)
def test_bounds_of_torque_parameters_leave_three_standard_deviations_to_either_side(block):
    """Or none is set; a prior is as wide for one number of the friction law as for another."""
    assert 3.0 * block.prior <= min(block.upper, -block.lower)
    if block is not MASS and np.isfinite(block.upper):
        assert block.prior == FRICTION[0].prior
