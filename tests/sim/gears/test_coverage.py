"""What recordings show of each joint: it is said where a joint's error would have been missed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

from armside.sim.gears import GearsCfg, analyse_gears, coverage, coverage_notes
from armside.sim.recordings import Stream, read_motion

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
    exact = analyse_gears(scenes.ARM, [scenes.recording(scenes.Scene(3, gear=0.0))], CFG)
    assert exact.found is None
    assert not exact.judgements
    smallest = np.array([joint.smallest for joint in coverage(exact)])
    gear = factor * smallest / scenes.AMPLITUDE
    done = analyse_gears(scenes.ARM, [scenes.recording(scenes.Scene(3, gear=gear))], CFG)
    assert found(done) == ({1, 2, 3} if seen else set())


def test_a_recording_without_a_judge_says_why(recordings, scenes):
    """One has no tracker; that of the other ends 3 s after the middle, on which it is aligned."""
    tracker = recordings[1].tracker
    middle = 0.5 * (tracker.time[0] + tracker.time[-1])
    seen = tracker.time < middle + 3.0
    short = replace(recordings[1], tracker=Stream(tracker.time[seen], tracker.values[seen]))
    done = analyse_gears(scenes.ARM, [replace(recordings[0], tracker=None), short], CFG)
    assert [judged.tool for judged in done.judgements] == [None, None]
    none, part = (str(judged.unjudged) for judged in done.judgements)
    assert none == "it has no samples of a tracker or of cameras"
    seconds = float(part.removeprefix("the tracker saw ").split()[0])
    assert 1.0 < seconds < 3.5
    notes = coverage_notes(done)
    assert f"{short.name}: not judged at the tool: {part}" in notes
    assert f"{recordings[0].name}: not judged at the tool: {none}" in notes


@pytest.mark.parametrize("named", ["cameras.mat", "ContinuousEvalutionTracker.mat"])
def test_cameras_of_a_day_are_read_by_either_spelling_or_missed_by_name(named, tmp_path):
    rng, time = np.random.default_rng(0), np.arange(0.0, 12.0, 0.01)[:, None]
    smooth = np.sin(time + rng.uniform(0.0, 6.0, 6)) + 3.0
    robot = {"tRobot": time, "q": smooth, "tImu": time, "z": smooth}
    savemat(tmp_path / "ContinuousEvaluation.mat", robot)
    savemat(tmp_path / named, {"t": time, "p": smooth[:, :3]})
    read = read_motion(tmp_path)
    assert (read.tracker is None) is (named == "cameras.mat")
    said = "cameras: there is no ContinuousEvaluationTracker.mat, and cameras.mat is not read"
    assert (said in read.notes) is (named == "cameras.mat")
