"""A part is cut in one run, where and when its plan says, and judged and learned by contour."""

from dataclasses import replace

import numpy as np
import pytest

from armside.ilc.measures.norms import two_norm
from armside.sim.evaluation.contour_error import contour_errors
from armside.sim.laser.experiment import prepare
from armside.sim.laser.loop import iterate
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.part_cut import PartCut
from armside.sim.part.arcs import arc, line
from armside.sim.part.curve import ChainCurve, Kind, centred, is_circle
from armside.sim.part.drawing import DrawnChain
from armside.sim.part.part import part_of
from armside.sim.part.plan import Cutting
from armside.sim.records.programmed_path import from_json, to_json


@pytest.fixture(scope="module")
def plate():
    outline = line((0.1, 0.2), (0.14, 0.2), (0.14, 0.23), (0.1, 0.23), (0.1, 0.2))
    hole = arc((0.11, 0.21), 0.005, 0.0, 2.0 * np.pi)
    part = part_of([DrawnChain(outline, "plate", ""), DrawnChain(hole, "hole", "")])
    return PartCut(part=part, cutting=Cutting(speed=0.06, rapid=0.2), pose="p2")


@pytest.fixture(scope="module")
def experiment(plate):
    return prepare(plate)


def test_the_tool_follows_each_contour_at_its_place_around_the_pose(experiment, plate):
    motion = experiment.motion
    middle = np.array(experiment.cut.tool_pose.position)
    box = np.array([motion.position.min(axis=0), motion.position.max(axis=0)])
    np.testing.assert_allclose(box.mean(axis=0)[:2], middle[:2], atol=2e-3)  # leads stick out
    np.testing.assert_allclose(motion.position[:, 2], middle[2])
    for cut, planned in zip(motion.cuts, plate.plan.cuts, strict=True):
        first, last = cut.contour_time
        np.testing.assert_allclose(cut.point(first), cut.turn.points[0], atol=1e-9)
        np.testing.assert_allclose(cut.point(last), cut.turn.points[-1], atol=1e-9)
        assert cut.turn.closed
        assert cut.end - cut.start == pytest.approx(planned.seconds)


def test_the_tool_rests_while_the_beam_pierces(experiment):
    motion = experiment.motion
    for cut in motion.cuts:
        resting = (motion.time >= cut.start - 0.3) & (motion.time <= cut.start)
        assert np.ptp(motion.position[resting], axis=0).max() < 1e-12
    speed = np.linalg.norm(np.diff(motion.position, axis=0), axis=1) / motion.step
    assert speed.max() <= 0.2 * 1.001
    assert speed[motion.is_on_contour(motion.time)[:-1]].max() <= 0.06 * 1.001


def test_a_tool_on_its_path_has_no_error_and_one_beside_it_has_that_of_its_place(experiment):
    motion = experiment.motion
    exact = contour_errors(motion, motion.time, motion.position, 2e-4)
    for error in exact:
        assert error.maxdev < 1e-9
        assert error.position < 1e-9
    moving = motion.time > 0.3
    beside = motion.position + 3e-5 * moving[:, np.newaxis] * np.array([0.6, 0.8, 0.0])
    for error in contour_errors(motion, motion.time, beside, 2e-4):
        assert error.maxdev < 1e-9
        assert error.position == pytest.approx(3e-5, rel=1e-6)


def test_roundness_is_that_of_the_edge(experiment):
    """An ellipse of 1 % in a hole: the difference of its half axes."""
    motion = experiment.motion
    (hole,) = [i for i, cut in enumerate(motion.cuts) if cut.kind is Kind.HOLE]
    centre = motion.places[hole].plane.origin
    squeezed = motion.position.copy()
    near = np.linalg.norm(motion.position - centre, axis=1) < 6e-3
    squeezed[near, 0] = centre[0] + 1.01 * (motion.position[near, 0] - centre[0])
    error = contour_errors(motion, motion.time, squeezed, 2e-4)[hole]
    assert error.roundness == pytest.approx(0.01 * 4.9e-3, rel=0.05)


def test_the_path_on_disk_is_the_path_of_the_run(experiment):
    motion = experiment.motion
    again = from_json(to_json(motion))
    np.testing.assert_array_equal(again.position, motion.position)
    assert [cut.contour_time for cut in again.cuts] == [c.contour_time for c in motion.cuts]
    assert to_json(again) == to_json(motion)


def test_a_part_beyond_the_reach_is_refused_with_the_place_in_the_drawing(plate):
    far = replace(plate, pose="p3", robot="irb1400")
    prepare(far)
    large = line((0.0, 0.0), (2.0, 0.0), (2.0, 0.1), (0.0, 0.1), (0.0, 0.0))
    part = part_of([DrawnChain(large, "plate", "")])
    with pytest.raises(ValueError, match=r"out of reach at \(-?\d"):
        prepare(replace(far, part=part))


def test_motors_learn_the_part_as_one_record(experiment):
    before, after = iterate(experiment, MotorAngles().prepare(experiment), 1)
    assert after.correction.shape == experiment.loaded.reference.shape
    assert (two_norm(after.error) < 0.6 * two_norm(before.error)).all()


def test_the_nearest_point_of_a_chain_is_that_of_the_geometry():
    rng = np.random.default_rng(0)
    chain = line((0.0, 0.0), (0.05, 0.0), (0.05, 0.02), (0.0, 0.02), (0.0, 0.0))
    p = rng.uniform(-0.01, 0.06, (200, 2))
    found = ChainCurve(chain).point(ChainCurve(chain).nearest(p))
    dense = chain.point(np.linspace(0.0, chain.length, 20001))
    best = np.linalg.norm(p[:, np.newaxis] - dense, axis=2).min(axis=1)
    np.testing.assert_allclose(np.linalg.norm(p - found, axis=1), best, atol=1e-5)
    assert is_circle(arc((0.1, 0.2), 0.03, 0.4, 2.0 * np.pi))
    curve, middle = centred(arc((0.1, 0.2), 0.03, 0.4, 2.0 * np.pi))
    np.testing.assert_allclose(middle, (0.1, 0.2))
    assert curve.smallest_radius == pytest.approx(0.03)


def test_the_error_of_a_part_is_that_of_its_contours_together(experiment):
    """RMS by length, the largest of the rest; one contour alone is the whole."""
    motion = experiment.motion
    beside = motion.position + 3e-5 * (motion.time > 1.0)[:, np.newaxis] * np.array([0.6, 0.8, 0.0])
    contours = experiment.cut.errors(motion, motion.time, beside)
    whole = experiment.cut.whole(motion, contours)
    length = np.array([cut.turn.length for cut in motion.cuts])
    squares = np.array([error.rms for error in contours]) ** 2
    assert whole.rms == pytest.approx(np.sqrt((squares * length).sum() / length.sum()))
    assert whole.position == max(error.position for error in contours) > 0.0


def test_corrections_of_contours_change_over_while_the_tool_rests(experiment):
    motion = experiment.motion
    share = experiment.cut.weights(motion)
    np.testing.assert_allclose(share.sum(axis=1), 1.0)
    blending = ((share > 0.0) & (share < 1.0)).any(axis=1)
    assert blending.sum() > 20
    assert np.ptp(motion.position[blending], axis=0).max() < 1e-9
    for i, place in enumerate(motion.places):
        assert (share[motion.time >= place.contour_time[0], i][:1] == 1.0).all()


def test_learning_ends_when_all_contours_have_converged(experiment):
    set_up = MotorAngles().prepare(experiment)
    found = list(iterate(experiment, set_up, 12, converged=0.5))
    assert found[-1].converged == (True, True)
    assert not all(found[-2].converged)
    assert len(found) < 12
    before, after = (np.linalg.norm(found[i].motor_error) for i in (0, -1))
    assert after < 0.5 * before


def test_the_arc_length_is_that_of_all_moves_and_cuts(experiment):
    """Beside the distances between samples, which cut corners by less than a sample's length."""
    motion = experiment.motion
    travelled = np.r_[0.0, np.linalg.norm(np.diff(motion.position, axis=0), axis=1).cumsum()]
    whole = sum(leg.path.length for leg in motion.legs)
    assert motion.arc_length[[0, -1]] == pytest.approx((0.0, whole))
    np.testing.assert_allclose(motion.arc_length, travelled, rtol=0.0, atol=2e-3)
