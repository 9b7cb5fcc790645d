"""A program learned from recordings of its runs on any robot.

A recording is brought to the program by the encoders: a model of the arm runs the same program, and
where both are at the same place of a row they are at the same time of the plan. So neither the
start of a log, nor its rate, nor how long the run took need be known.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from armside import kinematics
from armside.arrays import Array, check_recorded_time
from armside.ilc.learning import LoopState

from ...instruments.imu import ImuCfg, ImuSamples
from ...instruments.laser_tracker import TrackerSamples
from ...laser.experiment import Pass
from ...laser.measures import Measure, MotorAngles
from ...laser.tool_measure import Source, ToolPath
from ...notes import Cause, Note
from ...recordings.recorded_motion import GAP, LOST, MotionRecording, check_angles
from ...records.files import InputError
from ...robot.recording import Recording, Truth
from ...robot.virtual_robot import LOG_PERIOD
from .correction import LARGEST_OFFSET
from .own_program import REST_BEFORE, ProgramCut, fitted_rms, moved_points, own_program, text_of
from .program_text import ProgramText
from .scanner import Text
from .target_learning import Model, at_plan, contour_measure
from .tool_path import arc_lengths, arcs_of, rows_of
from .virtual_run import PlannedProgram

NEAR = 5e-3
"""Distance between the paths of recording and model by their encoders [m]. ESTIMATE: a controller
that does not anticipate the deflection of a large arm is off by 3 mm."""
ENDS = 5e-4
"""From both ends of a row [m], where places say nothing of time."""
KNOTS = 2e-3
"""Between places at which times are compared [m]."""
AS_LONG = 8e-3
"""Difference of times at the same place of a run that takes as long as the model's [s]. ESTIMATE:
friction that holds a motor makes 2 ms at 40 mm/s."""
EARLY = (1e-5, 3e-4)
"""Way of the tool from rest by which a start is found [m]: friction, which a model has wrong, makes
a run late by 3 ms farther on, and by 0.5 ms here."""
SMOOTH = 10.0
"""Low-pass of places [Hz]."""
STILL = 2e-4
"""Motion of the tool in the rest before the first row [m]. ESTIMATE"""
ALIKE = 0.95
"""Correlation of tracker and encoders, below which their axes differ. ESTIMATE"""
LATE = 0.02
"""Between clocks of tracker and encoders [s]. ESTIMATE"""
SHAPE = (4e-4, 2e-3)
"""RMS [m] by which motors may draw a row in another shape than the model's, and over its size.
ESTIMATE: 0.14 to 0.19 mm on individuals of development."""
PACE = (0.8, 1.3)
"""Time of a row over the model's. ESTIMATE: an interpolator that dips by 30 % takes 1.2."""
EVEN = 0.05
"""Pace beyond which a run is said to be slower or faster than programmed. ESTIMATE"""
OWN_SHARE = (0.5, 1.5)
"""Share of the targets' offsets in what the motors do otherwise than in the first run. ESTIMATE"""
TOLD = 2e-5
"""RMS of offsets from which a run is told from the first [m]. ESTIMATE"""
LEAST_TURN = 0.01
"""Turn [rad] and scale of the tracker's path against that of the encoders, beyond what is left of
the path when it is turned: the tool's own errors. ESTIMATE: 0.011 and 0.013, beside 0.028 that are
left, on a circle of 5 mm by an individual of development."""
SAME = 1e-6
"""Displacement of the path from that of the run before, below which nothing was learned [m]."""
FILTERED = 0.02
"""Before and after a beam that is lost, where filters make samples of others [s]. ESTIMATE"""
HOLE = 0.1
"""Longest time without samples of encoders or IMU [s]: they are interpolated. ESTIMATE"""
SENSORS = {"tracker": Source.TRACKER, "estimate": Source.ESTIMATE}


def measure_of_robot(name: str) -> Measure:
    """Measure by its name for a real robot, whose springs are assumed as its file has them."""
    return ToolPath(source=SENSORS[name], stiffness_error=0.0) if name != "motor" else MotorAngles()


@dataclass(frozen=True, eq=False)
class Places:
    """Places of a record along a row, low-passed, each at its time."""

    time: Array
    s: Array

    def at(self, s: Array) -> Array:
        """Times [s] at which it is at arc lengths [m]."""
        return np.interp(s, np.maximum.accumulate(self.s), self.time)


def aligned(program: PlannedProgram, recording: MotionRecording, offsets: Array) -> Pass:
    """The run of an own program with targets moved by (M, 3) [m], of which this is a recording.

    Raises InputError for one of another path, robot, axes or clock.
    """
    cut, encoders = program.experiment.cut, recording.encoders
    pose = kinematics.compile(cut.cell.robot).pose

    def tool(phi: Array) -> Array:
        return np.ascontiguousarray(pose(np.ascontiguousarray(phi))[:, :3, 3])

    spline = CubicSpline(encoders.time, encoders.values)
    time = np.arange(encoders.time[0], encoders.time[-1], LOG_PERIOD)
    start, clock = _clock(program, offsets, recording.name, time, tool(spline(time)), tool)
    if start < encoders.time[0] - LOG_PERIOD:
        text = f"begins {encoders.time[0] - start:.2g} s too late"
        raise InputError(f"{recording.name}: {text}: {REST_BEFORE} s before the first row are used")
    n = int(min(clock[0][-1] + REST_BEFORE, encoders.time[-1] - start) / LOG_PERIOD)
    own = LOG_PERIOD * np.arange(n, dtype=np.float64)
    phi = spline(np.maximum(own + start, encoders.time[0]))
    rest = tool(phi[own < REST_BEFORE - 0.08])
    if (moved := float(np.ptp(rest, axis=0).max())) > STILL:
        text = f"moves by {1e3 * moved:.2g} mm in the {REST_BEFORE} s before its first row"
        raise InputError(f"{recording.name}: the tool {text}: let it wait there")
    return Pass(
        recording=logged(own, phi),
        tracker=_tracked(recording, start, own, tool(phi)),
        imu=_imu(recording, start),
        clock=clock,
    )


def _clock(
    program: PlannedProgram,
    offsets: Array,
    name: str,
    time: Array,
    seen: Array,
    tool: Callable[[Array], Array],
) -> tuple[float, tuple[Array, Array]]:
    """Time [s] in a log at which the run begins, and times (P,) [s] of run and plan at the same
    places.

    time, seen: (K,) [s] and (K, 3) [m], of the log. A run that takes as long as the model's begins
    as that does, for places are also off by friction; another one goes by its places.
    """
    nominal, begin = program.experiment.nominal, 0
    ((ran, asked),) = Model(program, nominal).runs([(offsets, nominal)])
    model, pairs = tool(ran.motor_angle), list[tuple[Array, Array]]()
    for i, stretch in enumerate(program.stretches):
        ends = stretch.start + np.array([0.0, stretch.timing.duration])
        ends = np.interp(ends, asked.plan_time, asked.run_time)
        first, last = np.searchsorted(ran.time, ends).tolist()
        path, speed = _even(model[max(first - 1, 0) : last + 1]), stretch.timing.top_speed
        found, begin = _followed(path, time, seen, begin, speed)
        own, _ = _followed(path, ran.time, model, max(first - 1, 0), speed)
        where = f"row {i + 1} of {text_of(program).program.source}"
        if found is None or own is None:
            far = f"within {1e3 * NEAR:g} mm from one end to the other"
            why = "a run of another program, or a part of it is missing"
            raise InputError(f"{name}: no motion along {where}, {far}: {why}")
        length = float(arc_lengths(path)[-1])
        s = np.linspace(ENDS, length - ENDS, max(int(length / KNOTS), 4))
        at, own_at = found.at(s), own.at(s)
        drawn = CubicSpline(time, seen)(at) - np.stack(
            [np.interp(s, arc_lengths(path), column) for column in path.T], axis=1
        )
        off = float(np.sqrt(np.sum(np.var(drawn, axis=0))))
        if off > SHAPE[0] + SHAPE[1] * length:
            text = f"the motors draw another shape, by {1e3 * off:.2g} mm RMS"
            what = "is it a run of this program? For one of a learned program say --from"
            raise InputError(f"{name}: along {where} {text}: {what}")
        plan = np.interp(own_at, asked.run_time, asked.plan_time) - stretch.start
        first, last = stretch.timing.cruise
        cruise = (plan >= first) & (plan <= last) if last > first else np.full(len(s), True)
        at, own_at = at[cruise], own_at[cruise]
        if len(at) == 0 or (np.diff(at) <= 0.0).any():
            raise InputError(f"{name}: the tool rests or goes back along {where}")
        pace = float(np.median(np.diff(at) / np.diff(own_at)))
        if len(at) > 1 and not PACE[0] <= pace <= PACE[1]:
            text = f"takes {pace:.3g} times as long as programmed, not {PACE[0]:g} to {PACE[1]:g}"
            what = "run it at an override of 100 %, at the speed that stands in it"
            raise InputError(f"{name}: {where} {text}: {what}")
        ramps = ends - own_at[[0, -1]]  # as fast as planned, for slow places say little of time
        at = np.r_[at[0] + ramps[0], at, at[-1] + ramps[1]]
        pairs.append((at, np.r_[ends[0], own_at, ends[1]]))
    log, own_time = (np.concatenate(each) for each in zip(*pairs, strict=True))
    log = np.maximum.accumulate(log)  # ramps of two rows that meet
    start = float(np.median((log - own_time)[:5]))
    if np.abs(log - own_time - start).max() > AS_LONG:
        plan = np.interp(own_time, asked.run_time, asked.plan_time)
        return start, (np.r_[0.0, log - start], np.r_[0.0, plan])
    away = np.linalg.norm(model - model[0], axis=1)
    early = (away > EARLY[0]) & (np.arange(len(away)) < int((away > EARLY[1]).argmax()))
    path, at = CubicSpline(time, seen), ran.time[early]
    rest = path(start + np.linspace(0.0, REST_BEFORE / 2, 25)).mean(axis=0)
    for _ in range(10):
        left, velocity = model[early] - model[0] - path(at + start) + rest, path(at + start, 1)
        start += float(np.clip((velocity * left).sum() / (velocity**2).sum(), -1e-2, 1e-2))
    return start, (asked.run_time, asked.plan_time)


def _check_own(
    program: PlannedProgram, name: str, runs: tuple[Pass, Pass], displacement: Array
) -> None:
    """Refuse a recording whose motors differ from those of the first by another displacement of the
    path than (N, 3) [m]."""
    motion, pose = program.experiment.motion, kinematics.compile(program.experiment.cut.cell.robot)
    on, tools = motion.is_on_contour(motion.time), list[Array]()
    for run in runs:
        tool = np.ascontiguousarray(pose.pose(run.recording.motor_angle)[:, :3, 3])
        assert run.clock is not None
        tools.append(at_plan(program, tool, *run.clock)[on])
    u = displacement[on]
    if float(np.sqrt(np.mean(np.sum(u**2, axis=1)))) < TOLD:
        return
    share = float(np.sum((tools[1] - tools[0]) * u) / np.sum(u**2))
    if not OWN_SHARE[0] <= share <= OWN_SHARE[1]:
        text = f"the motors follow {share:.2f} of what the last step moved the targets by"
        raise InputError(f"{name}: {text}: it is no recording of the program of this run")


def _even(path: Array, step: float = 1e-4) -> Array:
    s = arc_lengths(path)
    grid = np.linspace(0.0, s[-1], int(s[-1] / step) + 2)
    return np.stack([np.interp(grid, s, column) for column in path.T], axis=1)


def _followed(
    path: Array, time: Array, seen: Array, begin: int, speed: float
) -> tuple[Places | None, int]:
    """Places along a path (K, 3) of positions (N, 3) [m] from a sample on, the first time that they
    follow it to its end, and the sample of that; None where they do not."""
    slow = np.linalg.norm(np.gradient(seen, LOG_PERIOD, axis=0), axis=1) < 0.5 * speed
    near = slow & (np.linalg.norm(seen - path[0], axis=1) < NEAR)
    near[:begin] = False
    s, tangent = arc_lengths(path), np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    reach = int(3e-3 / s[1])
    for first in np.flatnonzero(near & ~np.r_[False, near[:-1]]):
        now, found = 0, list[float]()
        for point in seen[first:]:
            low = max(now - reach // 10, 0)
            distance = np.linalg.norm(path[low : now + reach] - point, axis=1)
            if distance.min() > NEAR:
                break
            now = low + int(distance.argmin())
            found.append(float(s[now] + (point - path[now]) @ tangent[now]))
            if len(found) > 25 and found[-25] > s[-1] - ENDS:
                places = np.clip(found, 0.0, s[-1])
                smooth = butter(2, 2.0 * SMOOTH * LOG_PERIOD, output="sos")
                low_passed = sosfiltfilt(smooth, places, padtype="constant")
                end = int(first) + len(found)
                return Places(time[int(first) : end], np.asarray(low_passed)), end - 25
    return None, begin


def logged(time: Array, phi: Array) -> Recording:
    """Record of a log (N,) [s], (N, n) [rad] whose ground truth nobody knows."""
    rows, n = len(time), phi.shape[1]
    axes, vector = np.full((rows, n), np.nan), np.full((rows, 3), np.nan)
    truth = Truth(
        time=time,
        gear_angle=axes,
        spring_angle=axes,
        motor_torque=axes,
        tool_position=vector,
        tool_quaternion=np.full((rows, 4), np.nan),
        imu_acceleration=vector,
        imu_angular_velocity=vector,
        qpos=axes,
    )
    return Recording(
        time=time,
        reference=phi,
        correction=np.zeros_like(phi),
        motor_angle=phi,
        motor_torque=axes,
        truth=truth,
    )


def _tracked(recording: MotionRecording, start: float, time: Array, tool: Array) -> TrackerSamples:
    """Of the tracker, on the clock of the run; NaN where there is none. Raises InputError for axes
    or a clock that are not those of the robot."""
    if recording.tracker is None:
        return _samples(time, np.full_like(tool, np.nan))
    own, values = recording.tracker.time - start, recording.tracker.values
    if own[0] > LOG_PERIOD or own[-1] < time[-1]:
        raise InputError(f"{recording.name}: the tracker does not see the whole run")
    spline = CubicSpline(own, values)
    seen = spline(time)
    a, b = seen - seen.mean(axis=0), tool - tool.mean(axis=0)
    if (ratio := float(np.linalg.norm(a) / np.linalg.norm(b))) > 10.0:
        text = f"moves {ratio:.3g} times as far as the encoders say: is it in millimetres?"
        raise InputError(f"{recording.name}: the tracker {text}")
    away, ours = (np.linalg.norm(each - each[0], axis=1) for each in (seen, tool))
    speed = np.gradient(ours, LOG_PERIOD)  # distances are the same in any axes
    late = float(((ours - away) * speed).sum() / (speed**2).sum())
    likeness = float((a * b).sum() / (np.linalg.norm(a) * np.linalg.norm(b)))
    if likeness < ALIKE:
        text = f"and encoders move alike by {likeness:.3f}, not {ALIKE}"
        axes = "its axes must be those of the robot's base"
        raise InputError(f"{recording.name}: tracker {text}: {axes}")
    if abs(late) > LATE:
        text = f"is {late:.3g} s behind the encoders: their stamps must be of one clock"
        raise InputError(f"{recording.name}: the tracker {text}")
    then = np.stack([np.interp(time - late, time, column) for column in tool.T], axis=1)
    scale, turn, left = _similar(then, seen)
    bound = left + LEAST_TURN
    for value, what in ((turn, "turned"), (abs(scale - 1.0), "scaled")):
        if value > bound:
            text = f"is {what} by {value:.2g} against the encoders, {bound:.2g} can be its errors"
            raise InputError(f"{recording.name}: the tracker {text}: are its axes the base's?")
    step = float(np.median(np.diff(own)))
    grid = step * np.arange(int(time[-1] / step) + 1, dtype=np.float64)
    lost = np.zeros(len(grid), dtype=bool)
    for i in np.flatnonzero(np.diff(own) > GAP * step):
        lost |= (grid > own[i] - FILTERED) & (grid < own[i + 1] + FILTERED)
    if lost.mean() > LOST:
        raise InputError(
            f"{recording.name}: the tracker sees {100 * (1 - lost.mean()):.0f} % of the run"
        )
    samples = _samples(grid, spline(np.maximum(grid, own[0])))
    return replace(samples, valid=samples.valid & ~lost)


def _similar(a: Array, b: Array) -> tuple[float, float, float]:
    """Scale, and turn and rest over the size, of the similarity from points (N, 3) to others
    (Umeyama, IEEE PAMI 13 (1991) 376). Of a turn only what it moves counts: none about a line."""
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    U, singular, V = np.linalg.svd(a.T @ b)
    singular[2] *= (sign := np.linalg.det(U @ V))
    turned, size = a @ (U * [1.0, 1.0, sign]) @ V, float(np.linalg.norm(a))
    scale = float(singular.sum()) / size**2
    moved, left = np.linalg.norm(turned - a), np.linalg.norm(b - scale * turned)
    return scale, float(moved) / size, float(left) / size


def _samples(time: Array, position: Array) -> TrackerSamples:
    valid = np.asarray(np.isfinite(position).all(axis=1))
    return TrackerSamples(time=time, position=position, valid=valid)


def _imu(recording: MotionRecording, start: float) -> ImuSamples | None:
    if recording.imu is None:
        return None
    time = recording.imu.time - start
    own = time >= 0.0
    cfg = ImuCfg()
    acceleration, rate = np.split(recording.imu.values[own], 2, axis=1)
    return ImuSamples(
        time=time[own],
        acceleration=acceleration,
        angular_velocity=rate,
        acceleration_clipped=np.abs(acceleration) >= cfg.accelerometer.range,
        angular_velocity_clipped=np.abs(rate) >= cfg.gyroscope.range,
    )


def _refuse_arcs_between(text: ProgramText) -> None:
    """An arc from row to row is a part of the path that no target of theirs corrects."""
    rows = rows_of(text)
    ends, begins = {row.moves[-1] for row in rows}, {row.moves[0] for row in rows}
    for i in arcs_of(text):
        if i in begins and i - 1 in ends:
            place = text.places[i]
            why = "an arc between rows cannot be learned: write it as short linear moves"
            place.text.fail(place.at, why)


class Learned(NamedTuple):
    """What one recorded run taught."""

    state: LoopState
    """Run k + 1 with its correction, and the error of run k."""
    rms: float
    """Distance of the tool from its rows, moved to fit, in the recorded run, by the measure [m]."""
    offsets: Array
    """(M, 3) [m], of the targets from those of the person's program."""
    texts: tuple[Text, ...]
    changed: int
    notes: tuple[Note, ...]

    @property
    def largest_offset(self) -> float:
        """[m]."""
        return float(np.linalg.norm(self.offsets, axis=1).max())


def learned_from(
    text: ProgramText,
    robot: str,
    measure: str,
    recordings: tuple[MotionRecording, MotionRecording],
    before: LoopState | None = None,
    payload: float | None = None,
) -> Learned:
    """Targets for the next run of a program.

    recordings: of its first run, and of run k, whose state is `before`; None for k = 0.
    payload: mass of the tool [kg]; that of the model if None. Raises
    InputError or ProgramError as `aligned` and `own_program`, ImuError for an IMU that cannot be
    used, and for targets that would move too far.
    """
    first, last = recordings
    home = tuple(first.encoders.values[0].tolist())
    cut = ProgramCut(program=text, robot=robot, home=home, payload=payload)
    for each in recordings:
        check_angles(cut.cell.limits, each)
        for stream in ("encoders", "imu") if measure == "estimate" else ("encoders",):
            if (samples := getattr(each, stream)) is not None:
                check_recorded_time(f"{each.name}: {stream}", samples.time, gap=HOLE)
    program = own_program(cut)
    _refuse_arcs_between(text)
    none = np.zeros((len(program.experiment.motion.time), 3))
    u = none if before is None else before.correction
    if u.shape != none.shape:
        raise InputError(f"{text.program.source} is not the program that was learned before")
    for each, name in ((first, "the first"), (last, "this")):
        if getattr(each, {"estimate": "imu", "motor": "encoders"}.get(measure, measure)) is None:
            other = ": an IMU is learned from with --measure estimate" * (each.imu is not None)
            raise InputError(f"{each.name}: {name} recording has no {measure} to learn from{other}")
    of_first = aligned(program, first, program.offsets(none))
    run = of_first if before is None else aligned(program, last, program.offsets(u))
    if before is not None:
        _check_own(program, last.name, (of_first, run), u)
    output = contour_measure(program, measure_of_robot(measure))(of_first)
    error = output.reference - output(run)
    if not np.isfinite(error).all():
        raise InputError(f"{last.name}: the error of the tool is not finite")
    memory, notes = None if before is None else before.memory, output.notes
    if measure != "estimate":  # springs are those of the robot's file, which is no fault
        notes = tuple(note for note in notes if note.cause is not Cause.IMU)
    if measure == "tracker" and not (seen := run.tracker.valid).all():
        lost = f"the laser tracker lost its beam in {100 * (1 - seen.mean()):.2g} % of the run"
        notes = (*notes, Note(cause=Cause.BEAM, text=f"{lost}: nothing is learned there"))
    assert run.clock is not None
    pace = program.pace(run.clock)
    if abs(pace - 1.0) > EVEN:
        told = f"the run takes {pace:.2f} times as long as programmed: a correction is of one speed"
        notes = (*notes, Note(cause=Cause.PROGRAM, text=told))
    law = output.law
    law.check(*error.shape)
    after, memory_after = law.step(u, error, memory)
    if memory is not None and memory_after.setbacks > memory.setbacks:
        back = "the error had grown: learning goes on from the best run, with half the step"
        notes = (*notes, Note(cause=Cause.GUARD, text=back))
    if before is not None and np.abs(after - u).max() < SAME:
        same = "no target is moved farther: what is left is nothing that targets mend"
        notes = (*notes, Note(cause=Cause.PROGRAM, text=same))
    offsets = program.offsets(after)
    moves = moved_points(program, offsets)
    size = output.size(error) if before is None else before.first_size
    found = Learned(
        state=LoopState(1 if before is None else before.k + 1, after, error, memory_after, size),
        rms=fitted_rms(program.experiment.motion, error),
        offsets=offsets,
        texts=text.edited(moves),
        changed=sum(text.edits(point, by) for point, by in moves.items()),
        notes=notes,
    )
    if found.largest_offset > LARGEST_OFFSET:
        most = f"at most {1e3 * LARGEST_OFFSET:g} mm are allowed"
        raise InputError(f"a target would move by {1e3 * found.largest_offset:.3g} mm, {most}")
    return found
