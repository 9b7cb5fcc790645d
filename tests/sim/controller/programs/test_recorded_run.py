"""Programs are learned from recordings of their runs, whose clocks and rates nobody knows."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.scripts.ran import ran

from armside.scripts.cli import main
from armside.sim.controller.programs import (
    VIRTUAL,
    PlannedProgram,
    learn_targets,
    read_program,
    read_program_file,
)
from armside.sim.controller.programs.own_program import ProgramCut, fitted_rms, own_program
from armside.sim.controller.programs.recorded_run import aligned, learned_from, measure_of_robot
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.experiment import CuttingPlant, prepare
from armside.sim.laser.specification import Cut
from armside.sim.recordings.recorded_motion import MotionRecording, Stream
from armside.sim.recordings.tables import write_motion_tables
from armside.sim.robot.virtual_robot import VirtualRobot

from .test_tool_path import text_of

UM = 1e-6
SEED = 3
AXES = Rotation.from_quat(Cut().tool_pose.quaternion, scalar_first=True)


@pytest.fixture(scope="module")
def text():
    """Twelve targets on a half circle of 5 mm radius, with a tool in a work object."""
    (stretch,) = PlannedProgram.of(prepare(Cut(), seed=SEED), 2e-3).stretches
    return text_of("rapid", stretch.row.targets[:12], turned=AXES)


@pytest.fixture(scope="module")
def program(text):
    return own_program(ProgramCut(program=read_program(text)), seed=SEED)


class Elsewhere:
    """The robot of the experiment, on which rows are run, and its recordings."""

    def __init__(self, program):
        self.program, plant = program, program.experiment.plant
        fresh = own_program(program.experiment.cut, seed=SEED).experiment.plant
        self.plant, self.model = fresh, plant.loaded.model

    def run(self, rows, interpolator=None):
        program = self.program
        if interpolator is not None:
            program = replace(program, interpolator=interpolator)
        asked = program.run(rows)
        robot = VirtualRobot(self.model, nominal=program.controller)
        plant = CuttingPlant(robot.load(asked.reference), self.plant.tracker, self.plant.rng)
        return plant.run(np.zeros_like(asked.reference)), asked


def recorded(run, late=0.0, every=1, rest=0.0):
    """A log that begins `rest` before the run, by a clock that is `late`, of every n-th sample."""
    streams = []
    for time, values in (
        (run.recording.time, run.recording.motor_angle),
        (run.tracker.time, run.tracker.position),
    ):
        before = np.arange(-rest, 0.0, time[1])
        still = np.repeat(values[:1], len(before), axis=0)
        stream = Stream(np.r_[before, time][::every] + late, np.r_[still, values][::every])
        streams.append(stream)
    return MotionRecording(name="rec", encoders=streams[0], tracker=streams[1], form="test")


LOGS = [
    ({}, None, 2e-3),
    ({"late": 1234.5678, "rest": 3.001}, None, 2e-3),
    ({"every": 3}, None, 3e-3),
    ({"late": -7.0}, "30 % dips", 8e-3),
    ({}, "sharp corners, 10 % dips", 4e-3),
]


@pytest.mark.parametrize(("log", "interpolator", "bound"), LOGS)
def test_a_log_is_aligned_by_its_own_motion_whatever_its_clock_rate_and_length(
    program, log, interpolator, bound
):
    """Places of the plan at the times of the log: 2 ms are made by friction, whose model is wrong;
    dips of 20 Hz are above the low-pass of places."""
    none = np.zeros((program.ends[-1], 3))
    how = None if interpolator is None else VIRTUAL[interpolator]
    run, asked = Elsewhere(program).run(program.rows(none), how)
    found = aligned(program, recorded(run, **log), none)
    (stretch,) = program.stretches
    begin, end = stretch.start + 0.15, stretch.start + stretch.timing.duration - 0.15
    plan = np.linspace(begin, end, 50)
    at = np.interp(plan, *found.clock[::-1])
    true = np.interp(plan, asked.plan_time, asked.run_time)
    # The log is cut to its own start: what both have is the motor angle at a place.
    ours = [np.interp(at, found.recording.time, a) for a in found.recording.motor_angle.T]
    theirs = [np.interp(true, run.recording.time, a) for a in run.recording.motor_angle.T]
    speed = np.abs(np.gradient(theirs, plan, axis=1)).max()
    assert np.abs(np.subtract(ours, theirs)).max() < bound * speed


def test_rows_with_stops_between_them_are_each_aligned_with_their_own():
    """Two rows of a circle; the robot rests for 0.4 s between them, which no program says."""
    (stretch,) = PlannedProgram.of(prepare(Cut(), seed=SEED), 2e-3).stretches
    stop = (",z,t\\WObj:=w; ! 8", ",fine,t\\WObj:=w; ! 8")
    text = text_of("rapid", stretch.row.targets[:17], turned=AXES, change=stop)
    program = own_program(ProgramCut(program=read_program(text)), seed=SEED)
    first, second = program.stretches
    assert [len(each.row.targets) for each in (first, second)] == [9, 9]
    run, asked = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log = recorded(run)
    between = np.interp(second.start, asked.plan_time, asked.run_time)

    def paused(stream):
        k = int(np.searchsorted(stream.time, between))
        pause = stream.time[k] + (stream.time[1] - stream.time[0]) * np.arange(100)
        pause = pause[pause < stream.time[k] + 0.4]
        time = np.r_[stream.time[:k], pause, stream.time[k:] + 0.4]
        still = np.repeat(stream.values[k : k + 1], len(pause), axis=0)
        return Stream(time, np.r_[stream.values[:k], still, stream.values[k:]])

    log = replace(log, encoders=paused(log.encoders), tracker=paused(log.tracker))
    found = aligned(program, log, np.zeros((program.ends[-1], 3)))
    for each, late in ((first, 0.0), (second, 0.4)):
        middle = each.start + 0.5 * each.timing.duration
        at = np.interp(middle, *found.clock[::-1]) - np.interp(
            middle, asked.plan_time, asked.run_time
        )
        assert at == pytest.approx(late, abs=5e-3)


def test_a_program_learned_by_hand_over_files_equals_the_run_in_process(
    text, program, tmp_path, monkeypatch, capsys
):
    """Read, run elsewhere, recording, learn, load: twice, with a clock of its own. Within 1 um the
    tool is where the same recordings in memory, of unrounded targets, bring it. `learn_targets`
    knows the clock of its controller: 2 ms of alignment over the 0.2 s that a target is felt are
    1 % of the targets' offsets."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.mod").write_bytes(text.content.encode("latin-1"))
    by_hand, in_process = Elsewhere(program), Elsewhere(program)
    current, state, kept, before = tmp_path / "part.mod", None, [], ""
    offsets = np.zeros((program.ends[-1], 3))
    for k in range(3):
        rows = own_program(replace(program.experiment.cut, program=read_program_file(current)))
        run, _ = by_hand.run([stretch.row for stretch in rows.stretches])
        same, _ = in_process.run(program.rows(offsets))
        tools = [each.recording.truth.tool_position for each in (run, same)]
        n = min(map(len, tools))
        assert np.linalg.norm(tools[0][:n] - tools[1][:n], axis=1).max() < 1 * UM
        if k == 2:
            break
        folder = tmp_path / f"recording-{k}"
        folder.mkdir()
        write_motion_tables(folder, recorded(run, late=77.7, rest=1.0), "csv")
        found = ran(tmp_path / f"run-{k}", f"program learn part.mod --recording {folder}", before)
        kept.append(recorded(same))
        learned = learned_from(read_program(text), "large", "tracker", (kept[0], kept[-1]), state)
        state, offsets = learned.state, learned.offsets
        assert found["rms"] == pytest.approx(learned.rms, abs=1 * UM)
        assert found["k"] == k
        current, before = tmp_path / f"run-{k}/part.mod", f"--from run-{k}"
    first = json.loads((tmp_path / "run-0/summary.json").read_text(encoding="utf-8"))
    assert found["rms"] < 0.25 * first["rms"]
    go_on = "program learn part.mod --from run-0 --out other --recording recording-"
    assert main(f"{go_on}0".split()) == 2
    assert "recording-0 is the recording of run k = 0: record run 1" in capsys.readouterr().err
    own = "program learn part.mod --from run-0 --out other --recording recording-1"
    assert main(f"{own} --measure motor".split()) == 2
    assert "learned with --measure tracker, and goes on with it" in capsys.readouterr().err
    bent = "program learn run-0/part.mod --recording recording-1 --out other"
    assert main(bent.split()) == 2
    assert "is a corrected program: learn gets your own program" in capsys.readouterr().err
    Path("recording-0").rename("moved")
    assert main(own.split()) == 2
    assert "recording-0, the recording of the first run, is needed" in capsys.readouterr().err
    Path("moved").rename("recording-0")
    shutil.copytree("recording-1", "recording-0", dirs_exist_ok=True)
    assert main(f"{go_on}1".split()) == 2
    assert "recording-0 is not as it was in the first run" in capsys.readouterr().err
    measure = measure_of_robot("tracker")
    _, one, two = learn_targets(program, measure, 2)
    assert found["rms"] < 1.2 * fitted_rms(program.experiment.motion, one.error)
    known = program.offsets(two.correction)
    assert np.abs(offsets - known).max() < 0.01 * np.linalg.norm(known, axis=1).max()


def test_the_rms_of_a_run_is_that_of_its_rows_moved_to_fit(program):
    """Of a place that is off by a constant, or out of the plane, nothing is left."""
    motion = program.experiment.motion
    tangent = np.gradient(motion.position, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
    place = np.array([3e-4, -2e-4, 5e-4])
    off = place - (tangent @ place)[:, None] * tangent
    assert fitted_rms(motion, off) < 0.01 * UM
    wave = np.where(np.arange(len(off)) % 2, 1e-4, -1e-4)[:, None] * [0.0, 0.0, 1.0]
    assert fitted_rms(motion, off + wave) < 0.01 * UM
    across = np.cross([0.0, 0.0, 1.0], tangent) * np.sign(np.arange(len(off)) % 2 - 0.5)[:, None]
    assert fitted_rms(motion, off + 1e-4 * across) == pytest.approx(1e-4, rel=1e-3)


def without_tracker(recording):
    return replace(recording, tracker=None)


def millimetres(recording):
    tracker = recording.tracker
    return replace(recording, tracker=Stream(tracker.time, 1e3 * tracker.values))


def turned(recording):
    tracker = recording.tracker
    return replace(recording, tracker=Stream(tracker.time, tracker.values[:, [1, 0, 2]]))


def moved(recording, matrix):
    """As a tracker with other axes about the first point sees it."""
    tracker = recording.tracker
    values = tracker.values[0] + (tracker.values - tracker.values[0]) @ np.asarray(matrix)
    return replace(recording, tracker=Stream(tracker.time, values))


def turned_by_5_degrees(recording, axis=0):
    return moved(recording, Rotation.from_rotvec(np.radians(5.0) * np.eye(3)[axis]).as_matrix())


def turned_in_the_plane(recording):
    return turned_by_5_degrees(recording, 2)


def turned_back(recording):
    return moved(recording, Rotation.from_rotvec(np.radians([-5.0, 0.0, 0.0])).as_matrix())


def a_tenth_smaller(recording):
    return moved(recording, 0.9 * np.eye(3))


def late(recording):
    tracker = recording.tracker
    return replace(recording, tracker=Stream(tracker.time + 0.05, tracker.values))


def cut_off(recording):
    encoders = recording.encoders
    return replace(recording, encoders=Stream(encoders.time[60:], encoders.values[60:]))


def elsewhere(recording):
    encoders = recording.encoders
    return replace(recording, encoders=Stream(encoders.time, encoders.values + 0.02))


def in_degrees(recording):
    encoders = recording.encoders
    return replace(recording, encoders=Stream(encoders.time, np.degrees(encoders.values)))


def of_two_axes(recording):
    encoders = recording.encoders
    return replace(recording, encoders=Stream(encoders.time, encoders.values[:, :2]))


def at_half_speed(recording):
    both = (recording.encoders, recording.tracker)
    encoders, tracker = (Stream(2.0 * each.time, each.values) for each in both)
    return replace(recording, encoders=encoders, tracker=tracker)


REFUSED = [
    (at_half_speed, r"row 1 of m.mod takes (1.9|2)\.?\d* times as long as programmed"),
    (in_degrees, "are the angles in degrees?"),
    (of_two_axes, "the robot has 6 motors, the recording has 2"),
    (without_tracker, "rec: the first recording has no tracker to learn from"),
    (millimetres, r"moves 1\.?\d*e\+03 times as far as the encoders say"),
    (turned, "its axes must be those of the robot's base"),
    (turned_by_5_degrees, "the tracker is turned by"),
    (turned_in_the_plane, "the tracker is turned by"),
    (turned_back, "the tracker is turned by"),
    (a_tenth_smaller, "the tracker is scaled by"),
    (late, "s behind the encoders: their stamps must be of one clock"),
    (cut_off, r"rec: begins 0\.2\d? s too late"),
    (elsewhere, "rec: no motion along row 1 of m.mod"),
]


@pytest.mark.parametrize(("change", "reason"), REFUSED)
def test_a_recording_that_does_not_fit_is_refused(text, program, change, reason):
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log = change(recorded(run, rest=0.3 if change in (late, at_half_speed) else 0.0))
    with pytest.raises(ValueError, match=reason):
        learned_from(read_program(text), "large", "tracker", (log, log))


def stretched(recording, factor):
    """As by a controller that is slower than programmed."""
    both = (recording.encoders, recording.tracker)
    encoders, tracker = (Stream(factor * each.time, each.values) for each in both)
    return replace(recording, encoders=encoders, tracker=tracker)


@pytest.mark.parametrize("factor", [1.0, 1.12, 0.9])
def test_a_run_that_is_slower_or_faster_than_programmed_is_said_to_be(text, program, factor):
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log = stretched(recorded(run, rest=0.5), factor)
    notes = learned_from(read_program(text), "large", "tracker", (log, log)).notes
    said = [re.search(r"takes ([0-9.]+) times as long as programmed", n.text) for n in notes]
    found = [float(match[1]) for match in said if match]
    assert found == ([] if factor == 1.0 else [pytest.approx(factor, abs=0.02)])


def test_an_arc_between_two_rows_is_refused_by_its_line(text, program):
    """It is a part of the contour that no target corrects; as the way to a row it is none."""
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log, lines = recorded(run), text.content.splitlines(keepends=True)
    moves = [i for i, line in enumerate(lines) if line.lstrip().startswith("MoveL")]
    via, last = lines[moves[5]], lines[moves[6]].split("MoveL", 1)[1]
    position = via.split("MoveL", 1)[1].split(",v")[0]
    arc = [*lines[: moves[5]], f"MoveC{position},{last}", *lines[moves[6] + 1 :]]
    arced = replace(text, content="".join(arc))
    said = rf"m\.mod, line {moves[5] + 1}, column \d+: an arc between rows cannot be learned"
    with pytest.raises(ValueError, match=said):
        learned_from(read_program(arced), "large", "tracker", (log, log))


def test_a_run_of_another_program_is_refused(text, program):
    """Of a circle of 6 mm for 5 mm; of the first program for the second, and the first recording
    once more."""
    (stretch,) = program.stretches
    targets, own = stretch.row.targets, Elsewhere(program)
    larger = text_of("rapid", 1.2 * (targets - targets[0]) + targets[0], turned=AXES)
    neighbour = own_program(ProgramCut(program=read_program(larger)), seed=SEED)
    rows = [each.row for each in neighbour.stretches]
    other = recorded(Elsewhere(neighbour).run(rows)[0])
    with pytest.raises(ValueError, match=r"row 1 of m\.mod the motors draw another shape, by"):
        learned_from(read_program(text), "large", "tracker", (other, other))
    first, again = (recorded(own.run([stretch.row])[0], rest=0.1) for _ in range(2))
    state = learned_from(read_program(text), "large", "tracker", (first, first)).state
    for each in (again, first):
        with pytest.raises(ValueError, match="it is no recording of the program of this run"):
            learned_from(read_program(text), "large", "tracker", (first, each), state)


def without(recording, stream, first, last):
    """A recording without the samples of a stream in [first, last) s."""
    samples = getattr(recording, stream)
    kept = (samples.time < first) | (samples.time >= last)
    return replace(recording, **{stream: Stream(samples.time[kept], samples.values[kept])})


def test_where_the_beam_is_lost_nothing_is_learned(text, program):
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log, (stretch,) = recorded(run, rest=0.1), program.stretches
    middle = stretch.start + 0.5 * stretch.timing.duration
    lost = without(log, "tracker", middle - 0.03, middle + 0.03)
    found = learned_from(read_program(text), "large", "tracker", (lost, lost))
    time = program.experiment.motion.time
    away = np.linalg.norm(found.state.error, axis=1)
    assert away[np.abs(time - middle) < 0.03].max() < 1e-12
    assert away[np.abs(time - middle) < 0.1].max() > 10 * UM
    assert "nothing is learned there" in found.notes[-1].text
    gap = without(log, "encoders", middle - 0.1, middle + 0.1)
    with pytest.raises(ValueError, match=r"rec: encoders: .* no samples for 0\.\d+ s"):
        learned_from(read_program(text), "large", "tracker", (gap, gap))


def test_readings_at_the_range_of_an_imu_are_clipped(program):
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log = recorded(run)
    values = np.zeros((len(log.encoders.time), 6))
    values[7, 2], values[9, 4] = -ImuCfg().accelerometer.range, ImuCfg().gyroscope.range
    log = replace(log, imu=Stream(log.encoders.time + 5.0, values))
    imu = aligned(program, log, np.zeros((program.ends[-1], 3))).imu
    assert imu.acceleration_clipped.sum() == imu.angular_velocity_clipped.sum() == 1


def test_the_mass_of_the_tool_is_of_the_model_that_is_learned_on(text, program):
    """The motors of a heavier tool are set to another place by a controller that knows it."""
    run, _ = Elsewhere(program).run(program.rows(np.zeros((program.ends[-1], 3))))
    log = recorded(run)
    light, heavy = (
        learned_from(read_program(text), "large", "tracker", (log, log), None, mass).offsets
        for mass in (None, 80.0)
    )
    assert np.abs(heavy - light).max() > 1 * UM
