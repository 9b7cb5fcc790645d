"""Samples of a motion that a tracker saw."""

from types import SimpleNamespace

import numpy as np

from armside.sim.recordings.alignment.encoder_motion import STEP, coarse_lag
from armside.sim.recordings.alignment.tracker import MARGIN, TrackerAlignment
from armside.sim.recordings.recorded_motion import Stream


def test_the_first_and_last_half_second_of_a_tracker_do_not_count():
    """By its own clock, which is 0.2 s ahead and a thousandth fast."""
    found = TrackerAlignment(
        offset=0.2, rate=1e-3, R=np.eye(3), p=np.zeros(3), target=np.zeros(3), rms=0.0
    )
    time = np.arange(0.0, 10.0, 0.01)
    motion = SimpleNamespace(time=time)
    tracker = Stream(np.array([3.3, 7.7]), np.zeros((2, 3)))
    clock = time + 0.2 + 1e-3 * (time - time.mean())
    assert MARGIN == 1.0
    np.testing.assert_array_equal(found.covered(motion, tracker), (clock > 3.8) & (clock < 7.2))


def test_a_lag_is_that_of_the_clocks_whatever_the_rates_of_the_two():
    """Three bumps of speed, seen at 20 Hz by a clock that is 7.31 s ahead, and at 250 Hz."""

    def speed(t):
        return sum(np.exp(-(((t - at) / 0.3) ** 2)) for at in (3.0, 4.5, 8.0))

    own, robot = np.arange(1.0, 11.0, 0.05), np.arange(0.0, 10.0, 0.004)
    found = coarse_lag("tracker", (own + 7.31, speed(own)), (robot, speed(robot)))
    assert abs(found - 7.31) <= 0.5 * STEP + 1e-9
