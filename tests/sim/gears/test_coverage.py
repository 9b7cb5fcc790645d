"""What recordings show of each joint: it is said where a joint's error would have been missed."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.gears import GearsCfg, analyse_gears, coverage, coverage_notes
from armside.sim.recordings import Stream

CFG = GearsCfg(largest_order=200.0)


def kept(one, rows):
    """The recording with some samples of its IMU."""
    return replace(one, imu=Stream(one.imu.time[rows], one.imu.values[rows]))


def found(done):
    return set() if done.found is None else {term.joint for term in done.found.terms}


def named(notes):
    return {int(note[6]) for note in notes if note.startswith("joint ")}


def test_of_whole_recordings_nothing_is_said(analysis):
    assert found(analysis) == {1, 2, 3}
    assert coverage_notes(analysis) == ()
    for joint in coverage(analysis):
        assert joint.usable > 0.7  # the others turn too slowly


def test_an_imu_that_saw_half_of_the_motion_is_said_with_the_joints_that_are_missed(
    recordings, scenes
):
    half = kept(recordings[0], recordings[0].imu.time < 20.0)
    done = analyse_gears(scenes.ARM, [half], CFG)
    notes = coverage_notes(done)
    assert notes[0] == "scene 1: encoders and imu saw 48 % of the motion without holes"
    assert found(done) == {1, 3}
    assert named(notes) == {2}
    assert notes[1].startswith("joint 2: no order found: 28 % of samples usable, errors below")
    for joint in coverage(done):
        assert 0.2 < joint.usable < 0.49


def test_lost_samples_count_where_they_leave_holes_too_long_for_the_band(recordings, scenes):
    one = recordings[0]
    rows = np.random.default_rng(0).random(len(one.imu.time)) > 0.6
    done = analyse_gears(scenes.ARM, [kept(one, rows)], CFG)
    usable = [joint.usable for joint in coverage(done)]
    hole = 0.5 / CFG.band[1]
    steps = np.diff(one.imu.time[rows])
    assert max(usable) < steps[steps <= hole].sum() / steps.sum() + 0.02
    assert named(coverage_notes(done)) == {1, 2, 3} - found(done)


def test_a_joint_that_stands_still_cannot_be_judged(scenes):
    done = analyse_gears(scenes.ARM, [scenes.recording(scenes.Scene(5, held=2))], CFG)
    (note,) = coverage_notes(done)
    assert note == "joint 3: cannot be judged: 0 % of samples usable, 0 s of 10 needed"


@pytest.mark.parametrize(("factor", "seen"), [(0.5, False), (3.0, True)])
def test_an_error_is_found_from_the_amplitude_on_that_is_stated(scenes, factor, seen):
    """Of exact gears that amplitude is stated; gears of such an error are made with it."""
    one = scenes.recording(scenes.Scene(3, gear=0.0))
    smallest = np.array([c.smallest for c in coverage(analyse_gears(scenes.ARM, [one], CFG))])
    gear = factor * smallest / scenes.AMPLITUDE
    done = analyse_gears(scenes.ARM, [scenes.recording(scenes.Scene(3, gear=gear))], CFG)
    assert found(done) == ({1, 2, 3} if seen else set())
