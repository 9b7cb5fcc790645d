"""Random cuts are the same for the same seed, and can be made."""

import numpy as np
import pytest

from armside.sim.laser.experiment import prepare

from . import _random_cuts
from ._random_cuts import SPEEDS, random_cut


def test_a_random_cut_is_the_same_for_the_same_seed_and_can_be_made():
    cut, again, other = (random_cut("irb1400", seed) for seed in (100, 100, 101))
    assert cut == again
    assert cut.pose != other.pose
    assert SPEEDS[0] <= cut.speed <= SPEEDS[1]
    start = prepare(cut, seed=100).programmed[0]
    assert np.linalg.norm(start - cut.tool_pose.position) == pytest.approx(0.005, abs=1e-9)


def test_a_robot_that_reaches_nothing_is_named(monkeypatch):
    def unreachable(*_, **__):
        raise ValueError("beyond the reach")

    monkeypatch.setattr(_random_cuts, "prepare", unreachable)
    monkeypatch.setattr(_random_cuts, "_MOST_DRAWS", 3)
    with pytest.raises(RuntimeError, match="no cut of irb1400 found in 3 draws"):
        random_cut("irb1400", 0)
