"""Networks as they are built."""

import numpy as np
import pytest

from armside.sim.tuning.policies import Network


@pytest.mark.parametrize("counts", [(0, 0), (1, 2), (2, 1)])
def test_a_network_has_a_bias_for_each_weight(counts):
    layer = (np.eye(3), np.zeros(3))
    weights, biases = ((part,) * n for part, n in zip(layer, counts, strict=True))
    with pytest.raises(ValueError, match="{} and {}".format(*counts)):
        Network(weights=weights, biases=biases)
