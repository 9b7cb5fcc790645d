"""Path accuracy and repeatability of runs with known errors."""

import numpy as np
import pytest

from armside.sim.cell import LARGE_ROBOT_POSES
from armside.sim.evaluation.tool_error import path_measures
from armside.sim.laser import Cut
from armside.sim.motion.tool_motion import cut

POSE = LARGE_ROBOT_POSES["p1"]


def motion_of(specification):
    return cut(specification.path, POSE.quaternion, specification.speed)


def samples(motion):
    """Instants of a tracker, and the programmed positions."""
    time = np.arange(0.0, motion.time[-1], 1e-3)
    return time, motion.position_at(time)


def test_the_repeatability_of_displaced_runs_is_their_displacement():
    """Two runs 50 um to either side in x: apart where the contour runs along y, not along x."""
    motion = motion_of(Cut(pose=POSE))
    time, position = samples(motion)
    side = np.array([5e-5, 0.0, 0.0])
    found = path_measures(motion, [(time, position + side), (time, position - side)])
    # Where planes are crossed, the offset also shows by its square over the radius: 0.5 um.
    assert found.repeatability == pytest.approx(5e-5, abs=1e-6)
    assert found.accuracy < 1e-6


def test_a_common_offset_is_no_path_error_but_waves_of_height_are():
    motion = motion_of(Cut(pose=POSE))
    time, position = samples(motion)
    x = (position[:, 0] - POSE.position[0]) / 0.005
    waved = position + np.array([1e-3, 2e-3, -3e-3]) + np.outer(4e-4 * x, [0.0, 0.0, 1.0])
    found = path_measures(motion, [(time, waved)])
    assert found.accuracy == pytest.approx(4e-4, rel=1e-3)
    assert found.accuracy_in_plane < 1e-7
    assert np.isnan(found.repeatability)


def test_a_size_error_is_a_path_error():
    motion = motion_of(Cut(pose=POSE))
    time, position = samples(motion)
    centre = np.array(POSE.position)
    found = path_measures(motion, [(time, centre + 1.02 * (position - centre))])
    assert found.accuracy == pytest.approx(1e-4, rel=1e-3)
