"""Learning from scans of the parts: no other sensor, and springs that the first scan identifies."""

from dataclasses import replace

import numpy as np
import pytest
from tests.claims._tasks import DEVELOPMENT_SEED, tasks

from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.scan_measure import ScannedPart, VirtualScans
from armside.sim.motion.contour import outward_normal, slot, square
from armside.sim.robot.spread import Drawn
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.scan.shape import shape, taken_off
from armside.sim.scan.virtual_reading import ScanErrors

CUT = Cut(pose="p2", contour=square(0.02, 0.003))
EXACT = ScanErrors(
    **dict.fromkeys(
        ("beam", "from_cut_to_cut", "edge", "roughness", "image", "scale", "skew"), 0.0
    ),
    wobble=(0.0, 0.0),
)


@pytest.fixture(scope="module")
def experiment():
    return prepare(CUT, seed=3)


@pytest.fixture(scope="module")
def first(experiment):
    return experiment.plant.run(np.zeros_like(experiment.loaded.reference))


def left(measure, updates):
    rms = [one.tool_true.rms for one in learn(CUT, measure=measure, iterations=updates, seed=3)]
    return rms[-1] / rms[0]


def test_springs_of_the_first_scan_learn_better_than_assumed_ones():
    """Those assumed are off by up to 30 %."""
    found, assumed = (left(ScannedPart(identified=known), 2) for known in (True, False))
    assert found < 0.6 * assumed
    assert found < 0.15


def test_an_exact_scan_shows_the_tool_across_the_contour(experiment, first):
    """At each instant, but for a rigid motion, which the place of the sheet hides."""
    output = ScannedPart(scans=VirtualScans(EXACT)).prepare(experiment)(first)
    log, motion = first.recording, experiment.motion
    every = round(log.time[1] / log.truth.time[1])
    on = motion.is_on_contour(log.time)
    path = motion.plane.from_base(log.truth.tool_position[::every][on])[:, :2]
    true, change = shape(CUT.curve, path), (output(first) - output.reference)[on]
    inner = slice(3, -3)  # the ends are held
    seen = np.einsum("ij,ij->i", change[:, :2], outward_normal(CUT.curve.tangent(true.arc_length)))
    columns = taken_off(CUT.curve, true.arc_length)[inner]
    off = (seen - true.deviation)[inner]
    off -= columns @ np.linalg.lstsq(columns, off, rcond=1e-9)[0]
    assert np.std(true.deviation) > 100e-6
    # A deviation that is put 50 um beside its place, where springs are off, in the bends.
    assert np.std(off) < 0.06 * np.std(true.deviation)
    assert (change[:, 2] == 0.0).all()  # nothing of the height


def test_what_a_scan_does_not_see_keeps_the_error_in_the_pass_band():
    """Across the path it is what was seen, and in quick bends the low pass takes less of it."""
    experiment = prepare(replace(CUT, contour=slot(0.008, 0.003), speed=0.07), seed=3)
    first = experiment.plant.run(np.zeros_like(experiment.loaded.reference))
    output = ScannedPart(identified=False).prepare(experiment)(first)
    whole, across = (output(first) - output.reference)[:, :3], output.across(first)
    seen = np.linalg.norm(across, axis=1)
    normal = across / np.maximum(seen, 1e-12)[:, None]
    np.testing.assert_allclose(np.einsum("ij,ij->i", whole, normal), seen, rtol=0, atol=1e-9)
    band = output.measure.law.band(output.plants, experiment.turn_rate)
    low_pass = ZeroPhaseButterworth(band, LOG_PERIOD)
    lost = [np.einsum("ij,ij->i", each - low_pass(each), normal) for each in (whole, across)]
    assert np.linalg.norm(lost[0]) < 0.7 * np.linalg.norm(lost[1])


def test_springs_are_sought_until_the_scan_is_explained():
    """A slot of an individual of development, whose stiffer starts end at 0.16 mm."""
    _, cut = tasks(7, DEVELOPMENT_SEED + 1003)[6]
    runs = learn(replace(cut, individual=Drawn(1003)), measure=ScannedPart(), iterations=2, seed=3)
    rms = [one.tool_true.rms for one in runs]
    assert rms[-1] < 0.15 * rms[0]


def test_at_rest_nothing_is_learned(experiment, first):
    output = ScannedPart(identified=False).prepare(experiment)(first)
    still = np.linalg.norm(np.gradient(experiment.programmed, axis=0), axis=1) == 0.0
    assert still.any()
    assert (output(first) == output.reference)[still].all()


def test_the_same_part_is_scanned_the_same_again(experiment, first):
    """So that learning goes on from a stored run."""
    one, again = (VirtualScans()(experiment, first).contours["contour"] for _ in range(2))
    assert (one.deviation == again.deviation).all()


@pytest.mark.parametrize("scale", [0.0, 60.0])
def test_a_scan_of_another_part_is_refused(experiment, first, scale):
    def scans(of, run):
        scan = VirtualScans()(of, run)
        one = scan.contours["contour"]
        other = {"contour": replace(one, deviation=scale * one.deviation)} if scale else {}
        return replace(scan, contours=other)

    said = "mm RMS from its drawing" if scale else "has no contour 'contour'. Contours: none"
    with pytest.raises(ValueError, match=said):
        ScannedPart(scans=scans).prepare(experiment)(first)


def test_springs_that_explain_nothing_are_not_used_and_that_is_said(experiment, first, monkeypatch):
    monkeypatch.setattr("armside.sim.laser.scan_measure.springs_by_scan", lambda *of: None)
    output = ScannedPart().prepare(experiment)(first)
    (note,) = output.notes
    assert "those assumed are used" in note.text
    assert ScannedPart(identified=False).prepare(experiment)(first).notes == ()
