"""Plans keep half a beam from every contour, cut inner contours first and travel little."""

import os
from contextlib import nullcontext
from time import process_time

import numpy as np
import pytest
import shapely

from armside.sim.part.arcs import line
from armside.sim.part.beam_path import compensated, smooth
from armside.sim.part.curve import Kind
from armside.sim.part.drawing import Reading
from armside.sim.part.part import read_part
from armside.sim.part.plan import Cutting, plan

from .drawings import bracket, frame, new, save


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    file = save(bracket(new()), tmp_path_factory.mktemp("plan"))
    return plan(read_part(file, Reading(layers=("CUT",))), Cutting(beam=4e-4, joints=3))


def turn(cut):
    """The path without its leads."""
    return cut.path.part(cut.lead, cut.path.length - cut.lead)


def test_the_beam_runs_half_its_width_from_every_contour_on_the_side_of_the_scrap(planned):
    for cut in planned.cuts:
        drawn = shapely.LinearRing(cut.contour.chain.polygon())
        points = shapely.points(turn(cut).polygon())
        np.testing.assert_allclose(shapely.distance(points, drawn), 2e-4, atol=3e-6)
        inside = shapely.contains(shapely.Polygon(drawn), points)
        assert inside.all() if cut.contour.kind is Kind.HOLE else not inside.any()


def test_an_exact_offset_has_the_area_of_shapely_s(planned):
    for cut in planned.cuts:
        chain = cut.contour.chain
        outwards = cut.contour.kind is Kind.OUTLINE
        path = compensated(smooth(chain), 2e-4, outwards)
        polygon = shapely.Polygon(chain.polygon(1e-8))
        expected = polygon.buffer(2e-4 if outwards else -2e-4, quad_segs=256)
        assert path.area == pytest.approx(expected.area, abs=3e-6 * chain.length)


def test_the_outline_is_cut_last_and_leads_stay_in_the_scrap(planned):
    assert [cut.contour.kind for cut in planned.cuts] == [Kind.HOLE] * 10 + [Kind.OUTLINE]
    material = shapely.Polygon(
        planned.cuts[-1].contour.chain.polygon(),
        [cut.contour.chain.polygon() for cut in planned.cuts[:-1]],
    )
    for cut in planned.cuts:
        assert cut.lead > 0.0
        assert not shapely.LineString(cut.path.polygon()).intersects(material)
        assert np.abs(cut.path.kinks).max() < 1e-3, "the tool turns nowhere on the spot"


def test_micro_joints_are_on_the_outline_and_as_wide_as_asked(planned):
    joints = planned.cuts[-1].joints
    assert len(joints) == 3
    np.testing.assert_allclose([b - a for a, b in joints], planned.cutting.joint_width)
    assert not any(cut.joints for cut in planned.cuts[:-1])


def test_the_time_of_a_plan_is_that_of_its_moves(planned):
    cuts = sum(c.seconds + c.rapid_seconds for c in planned.cuts)
    assert planned.seconds == pytest.approx(cuts + 11 * planned.cutting.pierce)
    for cut in planned.cuts:
        assert cut.seconds > cut.path.length / planned.cutting.speed
        assert cut.reached_speed == pytest.approx(planned.cutting.speed, rel=1e-6)


NECK = [(10, 10), (30, 10), (30, 14.9), (31, 14.9), (31, 10), (50, 10)]
NECK += [(50, 20), (31, 20), (31, 15.2), (30, 15.2), (30, 20), (10, 20)]
SLOT = [(10, 10), (40, 10), (40, 10.3), (10, 10.3)]
NARROW = {
    "hole": (lambda s: s.add_circle((20, 20), 0.15), r"too wide for the radius of 0.15 mm at \("),
    "slot": (
        lambda s: s.add_lwpolyline(SLOT, close=True),
        r"too wide for the radius|wider than the slot at \(",
    ),
    "neck": (
        lambda s: s.add_lwpolyline(NECK, close=True),
        r"wider than the slot at \(30\.\d+, 15\.\d+\) mm",
    ),
}


def framed(draw, folder):
    """The part of a frame with what is drawn in it."""
    document = new()
    frame(document.modelspace())
    draw(document.modelspace())
    return read_part(save(document, folder))


@pytest.mark.parametrize("case", NARROW)
def test_a_beam_wider_than_an_opening_is_refused_with_its_place(case, tmp_path):
    draw, said = NARROW[case]
    part = framed(draw, tmp_path)
    plan(part, Cutting(beam=2e-4))
    with pytest.raises(ValueError, match=rf"#\w+: the beam of 0.4 mm is .*{said}"):
        plan(part, Cutting(beam=4e-4))


NEIGHBOURS = {
    "a ring narrower than the beam": (
        lambda s: (s.add_circle((30, 20), 10.0), s.add_circle((30, 20), 9.85)),
        r"CIRCLE #\w+: the beam of 0.2 mm cuts into CIRCLE #\w+ at \([-\d.]+, [-\d.]+\) mm, "
        r"0.0(5|49\d*) mm from its centre",
    ),
    "an open cut beside a hole": (
        lambda s: (s.add_circle((30, 20), 10.0), s.add_line((40.05, 10), (40.05, 30))),
        r"LINE #\w+: .* cuts into CIRCLE #\w+ at \(40, 20\) mm, 0.05 mm from its centre",
    ),
    "two holes": (
        lambda s: (s.add_circle((30, 20), 5.0), s.add_circle((40.1, 20), 5.0)),
        None,
    ),
}


@pytest.mark.parametrize("case", NEIGHBOURS)
def test_a_beam_that_cuts_into_another_contour_is_refused_with_both_names(case, tmp_path):
    draw, said = NEIGHBOURS[case]
    part = framed(draw, tmp_path)
    with nullcontext() if said is None else pytest.raises(ValueError, match=said):
        plan(part, Cutting(beam=2e-4))


@pytest.mark.parametrize("gap", [2.05, 0.9, 0.31, 0.22])
def test_the_beam_of_a_lead_stays_off_its_neighbours(gap, tmp_path):
    """An island in a hole: its lead of 2 mm would run across the gap [mm] into the hole's edge."""
    hole = [(10, 10), (40, 10), (40, 30), (10, 30)]
    inner = [(x + (gap if x < 20 else -gap), y + (gap if y < 20 else -gap)) for x, y in hole]
    both = framed(
        lambda s: [s.add_lwpolyline(each, close=True) for each in (hole, inner)], tmp_path
    )
    found = plan(both, Cutting(beam=2e-4))
    for cut in found.cuts:
        swath = shapely.LineString(cut.path.polygon())
        for other in found.cuts:
            if other is not cut:
                drawn = shapely.LinearRing(smooth(other.contour.chain).polygon())
                assert swath.distance(drawn) > 1e-4 - 5e-6


def test_corners_are_rounded_with_the_radius_that_is_asked_for(tmp_path):
    (cut,) = plan(framed(lambda space: None, tmp_path), Cutting(corner=1e-3)).cuts
    area = turn(cut).area
    w, h, r = 0.1 + 2e-4, 0.06 + 2e-4, 1e-3 + 1e-4
    assert area == pytest.approx(w * h - (4.0 - np.pi) * r**2, rel=1e-9)


def test_corners_at_both_ends_of_a_short_side_share_it():
    """Of 1 mm between two right angles, rounded by 2 mm if there were room: each takes 0.49 mm."""
    chain = line((0.0, 0.0), (0.05, 0.0), (0.05, 0.001), (0.0, 0.001), (0.0, 0.0))
    rounded = smooth(chain, 2e-3)
    assert np.abs(rounded.kinks).max() < 1e-6
    s = np.linspace(0.0, rounded.length, 2000)
    assert rounded.point(s)[:, 1].min() > -1e-9  # nothing turns back outside of the side
    heading = np.unwrap(rounded.direction(s))
    assert (np.diff(heading) > -1e-9).all()  # and the path turns one way only
    assert 1.0 / np.abs(rounded.curvature).max() == pytest.approx(0.49e-3, rel=1e-3)


def test_many_contours_are_planned_in_seconds(tmp_path):
    """Of different sizes, so that no speed profile serves two: 500 of them in 5 s, and a shared
    machine is granted three times as much. CI plans all of them, others a fifth."""
    n = 496 if os.environ.get("ARMSIDE_CI") else 96
    document = new()
    space = document.modelspace()
    frame(space, 480.0, 480.0, -15.0, -15.0)
    for i in range(n):
        space.add_circle((20.0 * (i % 23), 20.0 * (i // 23)), 3.0 + 0.01 * i)
    file = save(document, tmp_path)
    begun = process_time()
    part = read_part(file)
    found = plan(part)
    assert process_time() - begun < 15.0 * (n + 100) / 596
    assert len(found.cuts) == n + 1
