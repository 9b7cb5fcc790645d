"""Learning from scans of the parts: no other sensor, and springs that the first scan identifies."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.laser import Cut, prepare
from armside.sim.laser.loop import learn
from armside.sim.laser.scan_measure import ScannedPart, VirtualScans
from armside.sim.motion.contour import outward_normal, square
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
