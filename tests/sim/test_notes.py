"""Notes of runs: a limit that changed what was asked says so, once, with its runs."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.estimation.commissioning import Commissioning, OnFault
from armside.sim.imu import ImuExperiment
from armside.sim.imu import prepare as prepare_imu
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, MotorAngles, Source, ToolPath, iterate, learn, prepare
from armside.sim.laser.results import notes, pass_notes, results, status
from armside.sim.motion.contour import square
from armside.sim.motion.planner import slower_moves
from armside.sim.motion.timing import PathLimits
from armside.sim.notes import Cause, Note, counted, together


def cut_once(cut):
    """An experiment and its only iteration."""
    experiment = prepare(cut)
    return experiment, next(iterate(experiment, MotorAngles().prepare(experiment), 0))


@pytest.fixture(scope="module")
def ordinary():
    return cut_once(Cut())


def said(cut, cause):
    experiment, iteration = cut_once(cut)
    return [note.line for note in notes(experiment, [iteration]) if note.cause is cause]


def test_runs_with_the_same_note_become_one_line():
    note = Note(cause=Cause.BEAM, text="lost")
    (merged,) = together([note.at(3), note.at(0), note.at(1), note.at(3)])
    assert merged.line == "lost (k = 0 to 1, 3)"
    assert note.line == "lost"


def test_an_ordinary_cut_has_nothing_to_say(ordinary):
    experiment, iteration = ordinary
    assert notes(experiment, [iteration]) == []


def test_a_speed_that_corners_lower_is_said_with_asked_and_reached():
    (line,) = said(Cut(contour=square(0.02, 0.005), speed=0.167), Cause.SPEED)
    assert "from 167 to 80.62 mm/s" in line
    assert "1.3 m/s^2 across the path at a radius of 5 mm" in line


def test_a_speed_that_a_joint_lowers_names_its_axis():
    limits = PathLimits(acceleration=1e3, jerk=1e5)
    (line,) = said(Cut(robot="irb1400", speed=4.0, radius=0.1, limits=limits), Cause.SPEED)
    assert "speed limit of axis" in line


def test_a_ramp_that_acceleration_lengthens_is_said():
    (line,) = said(Cut(radius=0.1, speed=0.3), Cause.ACCELERATION)
    assert "1.3 m/s^2 along the path" in line


def test_a_saturated_drive_is_named(ordinary):
    experiment, iteration = ordinary
    hits = (("torque", 2, 0.4), ("torque", 3, 0.5), ("speed", 5, 0.6), ("joint", 1, 0.7))
    run = replace(iteration.run, recording=replace(iteration.run.recording, limits_hit=hits))
    assert [note.text for note in pass_notes(experiment, run)] == [
        "drives saturate: torque limit of axis 2, 3",
        "speed limit of axis 5 is reached",
        "hard stop of axis 1 is reached",
    ]


@pytest.mark.parametrize(("axes", "ends"), [((1, 2, 3, 4, 5, 6), "saturated"), ((2, 3), "done")])
def test_a_run_whose_every_drive_saturates_is_not_done(ordinary, axes, ends):
    _, iteration = ordinary
    hits = tuple(("torque", axis, 0.4) for axis in axes)
    run = replace(iteration.run, recording=replace(iteration.run.recording, limits_hit=hits))
    assert status([replace(iteration, run=run)], of_tool=False) == ends


def test_a_lost_beam_is_said(ordinary):
    experiment, iteration = ordinary
    tracker = iteration.run.tracker
    lost = replace(tracker, valid=np.zeros(len(tracker.time), dtype=bool))
    (note,) = pass_notes(experiment, replace(iteration.run, tracker=lost))
    assert note.cause is Cause.BEAM


def test_samples_of_the_imu_that_are_bridged_or_useless_are_said():
    experiment, iteration = cut_once(Cut(imu=ImuCfg()))
    run = iteration.run
    clipped = run.imu.acceleration_clipped.copy()
    clipped[40] = True
    gap = replace(run.imu, acceleration_clipped=clipped)
    (bridged,) = pass_notes(experiment, replace(run, imu=gap))
    assert "bridged" in bridged.text
    broken = replace(run.imu, acceleration=np.full_like(run.imu.acceleration, np.nan))
    (useless,) = pass_notes(experiment, replace(run, imu=broken))
    assert "not finite" in useless.text


def test_a_tool_that_got_worse_is_said_although_the_motors_got_better():
    """Operating point p3 of the thesis: what is learned from is blind to it."""
    experiment = prepare(Cut(pose="p3"), seed=0)
    found = results(experiment, list(learn(Cut(pose="p3"), iterations=5)))
    (note,) = found["notes"]
    assert note.cause is Cause.TOOL
    assert found["iterations"][-1]["arm_rms"] > found["iterations"][0]["arm_rms"]


class Worse:
    """Law that overshoots, inside a guard."""

    def __call__(self, correction, error):
        return correction - error

    def check(self, n_samples, n_columns):
        pass


def test_a_guard_that_goes_back_is_said():
    from armside.ilc.laws.wrappers import Guarded

    cut = Cut()
    law = Guarded(law=Worse(), weight=(1.0,) * 6)
    iterations = list(learn(cut, law=law, iterations=2))
    back = [note for note in notes(prepare(cut), iterations) if note.cause is Cause.GUARD]
    assert [note.runs for note in back] == [(1, 2)]


@pytest.mark.parametrize("source", [Source.TRACKER, Source.ESTIMATE])
def test_learning_without_a_usable_imu_says_so(source):
    """A tracker needs none; an estimate goes on only where it is told to."""
    experiment = prepare(Cut(imu=ImuCfg()))
    measure = ToolPath(source=source)
    if source is Source.ESTIMATE:
        measure = replace(measure, commissioning=Commissioning(on_fault=OnFault.GO_ON))

    class Deaf:
        """The plant, with an IMU that reads nothing."""

        def run(self, correction, /):
            run = experiment.plant.run(correction)
            nothing = np.zeros_like(run.imu.acceleration)
            return replace(run, imu=replace(run.imu, acceleration=nothing))

    iterations = list(iterate(experiment, measure.prepare(experiment), 1, plant=Deaf()))
    assert iterations[1].tool.rms < iterations[0].tool.rms
    of_imu = [note for note in notes(experiment, iterations) if note.cause is Cause.IMU]
    assert all("dead sensor" in note.text for note in of_imu)
    assert any("assumed springs" in note.text and note.runs == (0, 1) for note in of_imu)


def test_moves_that_stay_below_their_speed_are_said_with_what_limits_them():
    planned, *_ = prepare_imu(ImuExperiment())
    limited = {r.limited_by: r.instruction + 1 for r in planned.motion.reports if r.limited_by}
    found = list(slower_moves(planned.motion))
    assert {note.text.split(": ")[1] for note in found} == set(limited)
    assert all(str(limited[note.text.split(": ")[1]]) in note.text for note in found)


def test_notes_of_many_runs_are_counted_by_cause():
    low = [Note(cause=Cause.SPEED, text=f"lowered to {v}", runs=(v,)) for v in (1, 2)]
    lost = Note(cause=Cause.BEAM, text="lost")
    found = counted([[low[0]], [], [low[1], lost, lost]], "runs")
    assert [note.line for note in found] == [
        "lowered to 1 (in 2 of 3 runs)",
        "lost (in 1 of 3 runs)",
    ]
    assert counted([[], []], "runs") == []
