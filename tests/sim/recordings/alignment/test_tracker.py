"""Samples of a motion that a tracker saw."""

from types import SimpleNamespace

import numpy as np

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
