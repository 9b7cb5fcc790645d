"""Specification of a cut: lead-in and defaults of its path."""

import numpy as np
import pytest

from armside.sim.cell import LARGE_ROBOT_POSES
from armside.sim.laser.experiment import prepare
from armside.sim.laser.random_cuts import SPEEDS, random_cut
from armside.sim.laser.specification import SPIRAL_START, Cut, LeadIn
from armside.sim.motion.contour import Circle
from armside.sim.motion.tool_motion import cut
from armside.sim.robot.effects import Effect

POSE = LARGE_ROBOT_POSES["p1"]


def motion_of(specification):
    return cut(specification.path, POSE.quaternion, specification.speed)


def test_a_spiral_starts_inside_and_the_contour_is_the_same():
    arc = Cut(pose=POSE)
    spiral = Cut(pose=POSE, lead_in=LeadIn.SPIRAL)
    centre = np.array(POSE.position)
    assert np.linalg.norm(spiral.path.position(0.0) - centre) == pytest.approx(SPIRAL_START * 0.005)
    motion = motion_of(spiral)
    assert motion.reached_speed == 0.040
    on_contour = np.linalg.norm(motion.position[motion.on_contour] - centre, axis=1)
    np.testing.assert_allclose(on_contour, arc.radius, rtol=0, atol=1e-15)


def test_a_circle_has_a_lead_in_of_a_tenth():
    circle = Cut(pose=POSE, radius=0.007)
    assert circle.curve == Circle(0.007)
    assert circle.path.lead_in == pytest.approx(0.1 * 2 * np.pi * 0.007)


@pytest.mark.parametrize("without", [["ripple"], "ripple", ("lost-motion", Effect.RIPPLE)])
def test_a_text_in_place_of_an_effect_is_refused(without):
    with pytest.raises(ValueError, match=r"got '.*'. Effects: Effect.LOST_MOTION"):
        Cut(without=without)


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

    monkeypatch.setattr("armside.sim.laser.random_cuts.prepare", unreachable)
    monkeypatch.setattr("armside.sim.laser.random_cuts._MOST_DRAWS", 3)
    with pytest.raises(RuntimeError, match="no cut of irb1400 found in 3 draws"):
        random_cut("irb1400", 0)
