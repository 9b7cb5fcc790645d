"""Poses at which an arm stood still, found in bags."""

import numpy as np
import pytest

from armside.sim.recordings import BagTopics, read_poses

STANDS, MOVING, STEP = 6, 0.5, 0.02
"""Number of stands of the arm, time of each stand and each motion [s], step of the encoders."""
RNG = np.random.default_rng(0)
PHI = RNG.uniform(-1.0, 1.0, (STANDS, 2))
POINTS = RNG.uniform(-1.0, 1.0, (STANDS, 2, 3))
TURN = np.array([0.0, 0.6, 0.0, 0.8])
"""Quaternion, w last."""


def encoders(ros, jitter=0.0):
    """Stand and motion in turns."""
    time = np.arange(0.0, 2 * MOVING * STANDS - MOVING, STEP)
    knots = np.ravel([[2 * MOVING * k, 2 * MOVING * k + MOVING - STEP] for k in range(STANDS)])
    rng = np.random.default_rng(1)
    for t in time:
        phi = [np.interp(t, knots, np.repeat(PHI[:, i], 2)) for i in range(2)]
        yield t, ros.joint_state(t, ("a1", "a2"), phi + jitter * rng.normal(size=2))


def seen(k):
    """Stamp in the middle of a stand."""
    return 2 * MOVING * k + 0.5 * MOVING


@pytest.fixture
def bag(ros, tmp_path):
    """Target a with its orientation in each stand, and in motion; target b in all stands but one.

    The sign of a quaternion has no meaning, and changes here from sample to sample.
    """
    moving = [(t, ros.pose(t, (9.0, 9.0, 9.0), TURN)) for t in np.arange(0.75, 5.0, 1.0)]
    a = [
        (t, ros.pose(t, POINTS[k, 0] + 1e-5 * sign, sign * (TURN if k else TURN[::-1])))
        for k in range(STANDS)
        for t, sign in ((seen(k) - 0.02, -1), (seen(k), 1))
    ]
    b = [(seen(k), ros.point(seen(k), POINTS[k, 1])) for k in range(STANDS) if k != 3]
    topics = {"/joint_states": list(encoders(ros)), "/a": sorted(a + moving, key=lambda m: m[0])}
    return ros.write(tmp_path / "poses", topics | {"/b": b})


def test_each_stand_is_a_pose_and_motion_is_none(bag):
    source = read_poses(bag, BagTopics(tracker=("/a", "/b")))
    data = source.measurements
    np.testing.assert_allclose(data.phi, PHI, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(data.points[:, 0], POINTS[:, 0], rtol=0.0, atol=1e-12)
    assert np.isnan(data.points[3, 1]).all()
    others = np.arange(STANDS) != 3
    np.testing.assert_allclose(data.points[others, 1], POINTS[others, 1], rtol=0.0, atol=1e-12)
    assert "6 poses at which the arm stood still and a target was seen" in source.notes
    assert data.rotation is not None
    for k, angle in enumerate((2.0 * np.arccos(0.0), *[2.0 * np.arccos(0.8)] * 5)):
        assert np.arccos((np.trace(data.rotation[k]) - 1.0) / 2.0) == pytest.approx(angle)


def test_what_is_no_recording_of_poses_is_named(ros, bag, tmp_path):
    with pytest.raises(ValueError, match="2 topics for tracker: /a, /b"):
        read_poses(bag)
    with pytest.raises(ValueError, match="has no target of a tracker"):
        read_poses(bag, BagTopics(tracker=("none",)))
    b = [(seen(0), ros.point(seen(0), POINTS[0, 0]))]
    shaking = ros.write(tmp_path / "1", {"/j": list(encoders(ros, jitter=1e-3)), "/b": b})
    late = [(1e4, ros.point(1e4, POINTS[0, 0]))]
    apart = ros.write(tmp_path / "2", {"/j": list(encoders(ros)), "/b": late})
    for source in (shaking, apart):
        with pytest.raises(ValueError, match="no target was seen while the arm stood still"):
            read_poses(source)
    logged = [(k, message) for k, (_, message) in enumerate(list(encoders(ros))[::-1])]
    back = ros.write(tmp_path / "3", {"/j": logged, "/b": b})
    with pytest.raises(ValueError, match=r"row 2: .*clock runs backwards"):
        read_poses(back)
    with pytest.raises(ValueError, match="is no bag: topics"):
        read_poses(tmp_path, BagTopics(joints=("a1",)))
