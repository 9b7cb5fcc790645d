"""Tasks of any contour, and what is measured of the tool on them."""

import numpy as np
import pytest

from armside.sim.cell import LARGE_ROBOT_POSES
from armside.sim.cut.contour import Circle, hexagon, slot, square
from armside.sim.cut.task import SPIRAL_START, CircleTask, ContourTask, LeadIn
from armside.sim.cut.tool_motion import cut
from armside.sim.evaluation.path_accuracy import path_measures
from armside.sim.evaluation.tool_error import tool_error
from armside.sim.robot.statics import smoothed

POSE = LARGE_ROBOT_POSES["p1"]
SHAPES = {"square": square(0.02, 0.003), "slot": slot(0.03, 0.01), "hexagon": hexagon(0.02, 0.003)}


def motion_of(task):
    return cut(task.path, POSE.quaternion, task.speed)


def samples(motion):
    """Instants of a tracker, and the programmed positions."""
    time = np.arange(0.0, motion.time[-1], 1e-3)
    return time, motion.position_at(time)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_a_tool_that_is_only_beside_and_turned_cuts_true(shape):
    motion = motion_of(ContourTask(pose=POSE, contour=shape, across_tool=True))
    time, position = samples(motion)
    p = motion.plane.from_base(position)
    c, s = np.cos(0.01), np.sin(0.01)
    p[:, :2] = p[:, :2] @ np.array([[c, s], [-s, c]]) + [25e-3, -17e-3]
    side = tool_error(motion, time, motion.plane.to_base(p[:, :2]) + 2e-3 * motion.plane.axes[:, 2])
    assert side.rms < 1e-10
    assert side.maxdev < 1e-9


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_a_tool_that_cuts_all_around_too_large_is_that_far_off(shape):
    motion = motion_of(ContourTask(pose=POSE, contour=shape))
    time, _ = samples(motion)
    s = motion.timing.at(time - motion.rest_before)[0]
    tangent = motion.path.tangent(s)
    outwards = np.column_stack([tangent[:, 1], -tangent[:, 0], np.zeros(len(s))])
    side = tool_error(motion, time, motion.path.position(s) + 1e-4 * outwards)
    assert side.rms == pytest.approx(1e-4, rel=1e-3)
    assert side.maxdev == pytest.approx(1e-4, rel=1e-2)


def test_a_lost_beam_leaves_no_measure_of_any_contour():
    motion = motion_of(ContourTask(pose=POSE, contour=SHAPES["slot"]))
    time, position = samples(motion)
    position[len(position) // 2 :] = np.nan
    assert np.isnan(tool_error(motion, time, position).rms)


def test_a_spiral_starts_inside_and_the_contour_is_the_same():
    arc = CircleTask(pose=POSE)
    spiral = CircleTask(pose=POSE, lead_in=LeadIn.SPIRAL)
    centre = np.array(POSE.position)
    assert np.linalg.norm(spiral.path.position(0.0) - centre) == pytest.approx(SPIRAL_START * 0.005)
    motion = motion_of(spiral)
    assert motion.reached_speed == 0.040
    on_contour = np.linalg.norm(motion.position[motion.on_contour] - centre, axis=1)
    np.testing.assert_allclose(on_contour, arc.radius, rtol=0, atol=1e-15)


def test_runs_that_lie_apart_repeat_by_how_far_they_do():
    """Two runs 50 um to either side in x: apart where the contour runs along y, not along x."""
    motion = motion_of(CircleTask(pose=POSE))
    time, position = samples(motion)
    side = np.array([5e-5, 0.0, 0.0])
    found = path_measures(motion, [(time, position + side), (time, position - side)])
    # Where planes are crossed, the offset also shows by its square over the radius: 0.5 um.
    assert found.repeatability == pytest.approx(5e-5, abs=1e-6)
    assert found.accuracy < 1e-6


def test_a_common_offset_is_no_error_of_a_path_but_waves_of_height_are():
    motion = motion_of(CircleTask(pose=POSE))
    time, position = samples(motion)
    x = (position[:, 0] - POSE.position[0]) / 0.005
    waved = position + np.array([1e-3, 2e-3, -3e-3]) + np.outer(4e-4 * x, [0.0, 0.0, 1.0])
    found = path_measures(motion, [(time, waved)])
    assert found.accuracy == pytest.approx(4e-4, rel=1e-3)
    assert found.accuracy_in_plane < 1e-7
    assert np.isnan(found.repeatability)


def test_a_size_error_is_an_error_of_the_path():
    motion = motion_of(CircleTask(pose=POSE))
    time, position = samples(motion)
    centre = np.array(POSE.position)
    found = path_measures(motion, [(time, centre + 1.02 * (position - centre))])
    assert found.accuracy == pytest.approx(1e-4, rel=1e-3)


def test_a_smoothed_shift_keeps_ends_and_mean_and_has_no_steps():
    step = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 3.0]], 50, axis=0)
    smooth = smoothed(step)
    assert smooth.shape == step.shape
    np.testing.assert_allclose(smooth[[0, -1]], step[[0, -1]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(smooth.mean(axis=0), step.mean(axis=0), rtol=1e-12)
    assert np.abs(np.diff(smooth[:, 0])).max() == pytest.approx(1 / 5)


def test_a_circle_task_is_what_it_was():
    task = CircleTask(pose=POSE, radius=0.007)
    assert task.curve == Circle(0.007)
    assert task.path.lead_in == pytest.approx(0.1 * 2 * np.pi * 0.007)
