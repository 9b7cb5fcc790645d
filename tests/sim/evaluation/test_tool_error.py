"""The tool error is zero for a displaced contour and the size error of an enlarged one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armside.sim.cell import LARGE_ROBOT_POSES
from armside.sim.evaluation.tool_error import (
    attained,
    fit,
    path_measures,
    signed_distance,
    tool_error,
)
from armside.sim.laser import Cut
from armside.sim.motion.contour import Circle, hexagon, slot, square
from armside.sim.motion.tool_motion import cut

POSE = LARGE_ROBOT_POSES["p1"]
POLYGONS = {
    "square": square(0.02, 0.003),
    "hexagon": hexagon(0.02, 0.002),
    "slot": slot(0.03, 0.01),
}
SHAPES = {"circle": Circle(0.005)} | POLYGONS


def motion_of(specification):
    return cut(specification.path, POSE.quaternion, specification.speed)


def samples(motion):
    """Instants of a tracker, and the programmed positions."""
    time = np.arange(0.0, motion.time[-1], 1e-3)
    return time, motion.position_at(time)


@pytest.mark.parametrize("shape", POLYGONS.values(), ids=POLYGONS.keys())
def test_a_displaced_and_rotated_contour_has_no_tool_error(shape):
    motion = motion_of(Cut(pose=POSE, contour=shape, across_tool=True))
    time, position = samples(motion)
    p = motion.plane.from_base(position)
    c, s = np.cos(0.01), np.sin(0.01)
    p[:, :2] = p[:, :2] @ np.array([[c, s], [-s, c]]) + [25e-3, -17e-3]
    error = tool_error(
        motion, time, motion.plane.to_base(p[:, :2]) + 2e-3 * motion.plane.axes[:, 2]
    )
    assert error.rms < 1e-10
    assert error.maxdev < 1e-9


@pytest.mark.parametrize("shape", POLYGONS.values(), ids=POLYGONS.keys())
def test_an_enlarged_contour_has_that_tool_error(shape):
    motion = motion_of(Cut(pose=POSE, contour=shape))
    time, _ = samples(motion)
    s = motion.timing.at(time - motion.rest_before)[0]
    tangent = motion.path.tangent(s)
    outwards = np.column_stack([tangent[:, 1], -tangent[:, 0], np.zeros(len(s))])
    error = tool_error(motion, time, motion.path.position(s) + 1e-4 * outwards)
    assert error.rms == pytest.approx(1e-4, rel=1e-3)
    assert error.maxdev == pytest.approx(1e-4, rel=1e-2)


@pytest.mark.parametrize("flat", [0.5, 0.2, 0.02, 0.0])
def test_a_flattened_circle_has_the_error_of_its_flattening(flat):
    """A short arc of a huge circle would fit a flat path better: its centre is none of the cut."""
    motion = motion_of(Cut(pose=POSE))
    time, position = samples(motion)
    p = motion.plane.from_base(position)
    p[:, 1] *= flat
    error = tool_error(motion, time, motion.plane.to_base(p[:, :2]))
    assert error.maxdev == pytest.approx((1.0 - flat) * 0.005, rel=1e-3)


def test_a_lost_beam_gives_no_tool_error():
    motion = motion_of(Cut(pose=POSE, contour=POLYGONS["slot"]))
    time, position = samples(motion)
    position[len(position) // 2 :] = np.nan
    assert np.isnan(tool_error(motion, time, position).rms)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())
def test_the_signed_distance_is_the_displacement_along_the_normal(shape):
    s = np.linspace(0.0, shape.length, 500, endpoint=False)
    t = shape.tangent(s)
    outwards = np.column_stack([t[:, 1], -t[:, 0]])
    # Inwards by less than every radius, so that the foot stays the nearest point.
    offset = np.random.default_rng(1).uniform(-0.5e-3, 1e-3, len(s))
    p = shape.point(s) + offset[:, np.newaxis] * outwards
    np.testing.assert_allclose(signed_distance(shape, p), offset, rtol=0, atol=1e-12)


@settings(deadline=None, max_examples=30)
@given(
    x=st.floats(-1e-3, 1e-3),
    y=st.floats(-1e-3, 1e-3),
    angle=st.floats(-0.05, 0.05),
    name=st.sampled_from(["square", "hexagon", "slot"]),
)
def test_a_fit_reverses_displacement_and_rotation(x, y, angle, name):
    shape = SHAPES[name]
    p = shape.point(np.linspace(0.0, shape.length, 400, endpoint=False))
    c, s = np.cos(angle), np.sin(angle)
    moved = p @ np.array([[c, s], [-s, c]]) + [x, y]
    found = fit(shape, moved)
    np.testing.assert_allclose(found.deviation, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.points, p, rtol=0, atol=1e-10)


def test_a_fit_moves_a_circle_to_its_least_squares_centre_and_keeps_its_size():
    p = Circle(0.0051).point(np.linspace(0.0, 2 * np.pi * 0.0051, 300, endpoint=False))
    found = fit(Circle(0.005), p + np.array([2e-4, -1e-4]))
    np.testing.assert_allclose(found.points, p, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.deviation, 1e-4, rtol=0, atol=1e-12)


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


def test_attained_points_need_three_samples_of_the_contour_a_run():
    motion = motion_of(Cut(pose=POSE))
    time, position = samples(motion)
    on = np.flatnonzero(motion.is_on_contour(time))[:: len(time) // 8]
    three, two = ((time[i], position[i]) for i in (on[:3], on[:2]))
    assert np.isnan(attained(motion, [three, two])).all()
    assert np.isfinite(attained(motion, [three, three])).any()
