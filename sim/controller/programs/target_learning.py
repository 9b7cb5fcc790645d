"""Learning the targets of a program from the error of the tool across its path.

The inputs are offsets of the targets, in the plane across the path and along the plane's normal;
along the path an offset does nothing at constant speed. The output is the contour error: from each
place of the tool to the nearest of the path, never to that of the same time.

    c_{k+1}: e_m(c) + e_k - e_m(c_k) = 0        c <- c - (A^T A + rho (1 + r D^T D))^-1 A^T e

e_m is the error of a model of the arm with its friction and lost motion, run after run
(`laws.Simulated`). A is its sensitivity to each target, D are second differences along the path.
First A is that of the undisplaced path without Coulomb friction, whose steps hold for millimetres.
These passes end where friction holds a joint; from there A is that of the last run with friction,
and rho that of Levenberg and Marquardt (`Refined`), as long as the model predicts the runs
(`Confirmed`): of what the passes leave in corners half is left (development). So it was not the
B-spline that left it. A controller whose speed dips or whose set points are far apart shakes lost
motion loose: where the first run shows it, the model has it (`as_run`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from armside import kinematics
from armside.arrays import Array
from armside.ilc.laws import Law, Simulated
from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.laws.wrappers import Best, Guarded

from ...estimation.elasticity import Elasticity
from ...estimation.estimator import validity
from ...estimation.nominal import nominal_arm
from ...estimation.relative_path import relative_to_start
from ...laser.experiment import Experiment, Iteration, Pass
from ...laser.loop import Start, iterate
from ...laser.measures import Measure, MotorAngles
from ...laser.scan_measure import ScannedPart, ScanOutput
from ...laser.tool_measure import Source, ToolOutput, ToolPath
from ...notes import Note
from ...robot.effects import available
from ...robot.individual import Individual, embodied, with_friction
from ...robot.model import RobotModel
from ...robot.recording import Recording
from ...robot.run import cores, run_batch
from ...robot.virtual_robot import LOG_PERIOD, VirtualRobot
from .correction import LARGEST_OFFSET
from .tool_path import nearest_across
from .virtual_run import FINE, PlannedProgram, ProgramPlant, ProgramRun

PROBE = 3e-4
"""Offset of a target by which sensitivities are measured [m]."""
MEMORY = 0.2
"""Time after which a target is forgotten [s]: farther ones are probed in one run. ESTIMATE"""
SLIDING = 0.01
"""Coulomb friction of the model that sensitivities are those of, over that of the model."""
RHO, SMOOTH = 1e-3, 10.0
"""rho over the largest squared singular value of A, and r. Chosen on development, as all below."""
GAIN, PASSES = 0.8, 12
NEARBY = 1e-4
"""Offset by which the sensitivities of `Refined` are measured [m]."""
DAMPING, STEPS, TRIES, WORTH = 1e-4, 4, 3, 0.95
"""Of `Refined`: rho at first, most steps, tries with another rho in each, and the factor by which
the residual falls in a step that is followed by another."""
MISSED = 0.6
"""Part of a predicted change by which a run may miss it, for a model that is trusted. Of the second
update 0.15 to 0.3 were seen by the assumed interpolator, 0.85 and more where speeds dip by 30 %."""
HEIGHT = 0.1
"""Weight of errors along the plane's normal: a beam's focus forgives what its edge does not. Of 1.1
to 1.4 mm of height (RMS, development) 0.07 to 0.2 are left."""
DIPS = 0.02
"""Least dip of the speed at targets that is looked for. On development a program by dips of 30 %
ended at 0.1 to 0.8 by a model without, at 0.03 to 0.2 by one with them."""
CYCLES = (0.008, 0.012)
"""Other times between set points [s]: 125 Hz of UR's CB series, 12 ms of KUKA's KR C4."""
TREND = 0.05
"""[s], over which a trend of the speed is taken: of two targets."""
LEADS = 0.03
"""Weight of errors on leads, whose ends no target can mend."""
SETTLED = 0.06
"""Before the end of a row [s], from which nothing is learned."""
BEHIND, AHEAD = 3e-3, 1.2e-3
"""Along the path, where the place nearest to the tool is looked for [m]: tools lag behind."""
AXES = (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class ContourOutput:
    """Contour error of a run (N, 3) [m], base axes, weighted; at the instants of the plan."""

    program: PlannedProgram
    seen: Callable[[Pass], Array]
    """(N, 3) [m], of a run from the tool to the contour."""
    law: Law = field(repr=False)
    inner: Any = None
    """Output whose notes these are."""

    @property
    def reference(self) -> Array:
        return np.zeros((len(self.program.experiment.motion.time), 3))

    @property
    def notes(self) -> tuple[Note, ...]:
        return getattr(self.inner, "notes", ())

    def __call__(self, run: Pass) -> Array:
        return -self.seen(run)

    def size(self, error: Array) -> Array:
        return np.array([float(np.linalg.norm(error))])


def at_plan(program: PlannedProgram, signal: Array, run_time: Array, plan_time: Array) -> Array:
    """A signal (K, n) at the log of a run, at the instants of the plan."""
    plan = program.experiment.motion.time
    time = np.interp(plan, plan_time, run_time) + np.maximum(plan - plan_time[-1], 0.0)
    own = LOG_PERIOD * np.arange(len(signal), dtype=np.float64)
    return np.stack([np.interp(time, own, column) for column in signal.T], axis=1)


def across(program: PlannedProgram, position: Array, run_time: Array, plan_time: Array) -> Array:
    """(N, 3) [m], from the tool at positions (K, 3) [m] of a log, to the nearest place of the
    contour."""
    motion = program.experiment.motion
    tool = at_plan(program, position, run_time, plan_time)
    weight = np.where(motion.is_on_contour(motion.time), 1.0, LEADS)[:, np.newaxis]
    error, step = np.zeros_like(tool), 2.0 * FINE
    reach = np.arange(-round(BEHIND / step), round(AHEAD / step) + 1)
    for stretch in program.stretches:
        end = stretch.start + stretch.timing.duration - SETTLED
        own = np.flatnonzero((motion.time > stretch.start) & (motion.time < end))
        s = np.linspace(0.0, stretch.length, int(stretch.length / step) + 2)
        here = np.searchsorted(s, stretch.arc_length(motion.time[own]))
        near = np.clip(here[:, np.newaxis] + reach, 0, len(s) - 1)
        error[own] = -weight[own] * nearest_across(stretch.point(s), near, tool[own])[1]
    up = motion.plane.axes[:, 2]
    return error - (1.0 - HEIGHT) * np.outer(error @ up, up)


Sensitivity = tuple[np.ndarray, np.ndarray, Array]
"""Of a stretch: its targets (F,), instants (K,), and A (3 K, 2 F)."""


@dataclass(frozen=True, eq=False)
class Model:
    """The arm as it is known, in the robot's place: noise-free runs of a program."""

    program: PlannedProgram
    robot: RobotModel

    def __call__(self, displacement: Array) -> Array:
        """Contour error (N, 3) of the tool for a displaced path (N, 3) [m]."""
        return self._errors([self.program.offsets(displacement)], self.robot)[0]

    def _errors(self, offsets: list[Array], robot: RobotModel) -> list[Array]:
        start, runs = (
            self.program.experiment.programmed[0],
            self.runs([(o, robot) for o in offsets]),
        )
        return [
            across(self.program, start + _tool(recording), run.run_time, run.plan_time)
            for recording, run in runs
        ]

    def runs(
        self, programs: Sequence[tuple[Array, RobotModel]]
    ) -> list[tuple[Recording, ProgramRun]]:
        """Of offsets (M, 3) [m], each on its robot."""
        program = self.program
        runs = [program.run(program.rows(offsets)) for offsets, _ in programs]
        longest = max(len(run.reference) for run in runs)
        loaded = [
            VirtualRobot(robot, nominal=program.controller).load(_held(run.reference, longest))
            for run, (_, robot) in zip(runs, programs, strict=True)
        ]
        nothing = [None] * len(runs)
        found = run_batch(loaded, nothing, nothing, threads=min(cores(), len(runs)))
        return list(zip(found, runs, strict=True))

    @cached_property
    def sensitivity(self) -> list[Sensitivity]:
        """About the undisplaced path, without Coulomb friction."""
        none = np.zeros((self.program.ends[-1], 3))
        return self.about(none, with_friction(self.robot, SLIDING), PROBE)

    def about(self, offsets: Array, robot: RobotModel, probe: float) -> list[Sensitivity]:
        """Sensitivities to targets that are moved by `probe` [m] from their offsets (M, 3) [m]."""
        program, time = self.program, self.program.experiment.motion.time
        first = program.ends
        n = max(
            int(np.ceil(3.0 + MEMORY * s.timing.top_speed / s.row.spacing.min()))
            for s in program.stretches
        )
        frame = np.concatenate([stretch.frame for stretch in program.stretches])
        probes = [(k, d) for k in range(n) for d in (0, 1)]
        tried = np.repeat(offsets[np.newaxis], 1 + len(probes), axis=0)
        for moved_by, (k, d) in zip(tried[1:], probes, strict=True):
            own = program.free[k::n]
            moved_by[own] += probe * frame[own, d]
        base, *moved = self._errors([*tried], robot)
        felt = np.abs(program.basis.toarray()) > 0.0
        begins = np.where(felt.any(axis=0), felt.argmax(axis=0), len(time))
        found = list[Sensitivity]()
        for i, stretch in enumerate(program.stretches):
            rows = np.flatnonzero(stretch.during(time))
            own = program.free[(program.free >= first[i]) & (program.free < first[i + 1])]
            A = np.zeros((len(rows), 3, len(own), 2))
            for (k, d), error in zip(probes, moved, strict=True):
                probed = np.intersect1d(program.free[k::n], own)
                of = np.searchsorted(begins[probed], rows, side="right") - 1
                change = (error - base)[rows] / probe
                on = np.flatnonzero(of >= 0)
                A[on, :, np.searchsorted(own, probed)[of[on]], d] = change[on]
            found.append((own, rows, A.reshape(3 * len(rows), -1)))
        return found


def as_run(model: Model, first: Pass) -> Model:
    """By the controller, of those that are known, whose motors' speed varies as in a first run.

    Known are set points by `CYCLES`, and a speed that dips at targets: where it is (1 - dip cos^2)
    of that of the plan, the pace of a run is 1 / sqrt(1 - dip).
    """
    program, clock = model.program, first.clock
    assert clock is not None
    how, dip = program.interpolator, 1.0 - 1.0 / program.pace(clock) ** 2
    others = [replace(how, dip=dip)] if dip > DIPS else [replace(how, cycle=c) for c in CYCLES]
    known = [replace(model, program=replace(program, interpolator=i)) for i in (how, *others)]
    varies, none = _varies(program, first.recording, clock), np.zeros((program.ends[-1], 3))
    apart = list[float]()
    for each in known:
        ((log, run),) = each.runs([(none, model.robot)])
        apart.append(abs(varies - _varies(program, log, (run.run_time, run.plan_time))))
    return known[int(np.argmin(apart))]


def _varies(program: PlannedProgram, log: Recording, clock: tuple[Array, Array]) -> float:
    """Standard deviation of the motors' speed along the path over its trend, where the plan has
    constant speed."""
    pose = kinematics.compile(program.experiment.cut.cell.robot).pose
    tool = pose(np.ascontiguousarray(log.motor_angle))[:, :3, 3]
    speed = np.linalg.norm(np.diff(tool, axis=0), axis=1)
    trend = gaussian_filter1d(speed, TREND / LOG_PERIOD)
    steady = program.is_steady(np.interp(log.time[:-1], *clock))
    return float(np.std(speed[steady] / trend[steady])) if steady.any() else 0.0


def _held(reference: Array, n: int) -> Array:
    return np.vstack([reference, np.repeat(reference[-1:], n - len(reference), axis=0)])


def _tool(recording: Recording) -> Array:
    every = round(LOG_PERIOD / float(recording.truth.time[1]))
    return relative_to_start(recording.truth.tool_position[::every])[:, :3]


Damped = tuple[np.ndarray, np.ndarray, Array]
"""Of a stretch: its targets (F,), instants (K,), and (A^T A + ...)^-1 A^T, (2 F, 3 K)."""


@dataclass(frozen=True, eq=False)
class TargetStep(FirstOrderLaw):
    """One step of all targets by the sensitivities of a model."""

    model: Model

    def check(self, n_samples: int, n_columns: int) -> None:
        if n_columns != 3:
            raise ValueError(f"displacements of a path have 3 columns, got {n_columns}")

    def __call__(self, correction: Array, error: Array, /) -> Array:
        return correction + GAIN * damped_step(self.model.program, self._damped, error)

    @cached_property
    def _damped(self) -> list[Damped]:
        return damped(self.model.sensitivity, RHO)


def damped(sensitivity: list[Sensitivity], rho: float) -> list[Damped]:
    """Damped inverses. rho: over the largest squared singular value of A."""
    found = list[Damped]()
    for own, rows, A in sensitivity:
        D = np.kron(np.diff(np.eye(len(own)), 2, axis=0), np.eye(2))
        square = A.T @ A
        least = rho * np.linalg.norm(square, ord=2)
        kept = square + least * (np.eye(len(square)) + SMOOTH * D.T @ D)
        found.append((own, rows, np.asarray(np.linalg.solve(kept, A.T), dtype=np.float64)))
    return found


def damped_step(program: PlannedProgram, inverses: list[Damped], error: Array) -> Array:
    """Displacement of the path (N, 3) [m] against an error (N, 3) [m]."""
    frame = np.concatenate([stretch.frame for stretch in program.stretches])
    offset = np.zeros((program.ends[-1], 3))
    for own, rows, inverse in inverses:
        step = -(inverse @ error[rows].ravel()).reshape(-1, 2)
        offset[own] = np.einsum("fd,fdi->fi", step, frame[own])
    return program.basis @ offset


@dataclass(frozen=True, kw_only=True, eq=False)
class Refined(Simulated):
    """Passes on the model, and Levenberg-Marquardt steps from where they end, never to offsets that
    `corrected` refuses."""

    steps: int = STEPS
    """At most."""

    def __call__(self, correction: Array, error: Array, /) -> Array:
        model, rho = model_of(self), DAMPING
        program = model.program
        best = super().__call__(correction, error)
        if not self.steps:
            return best
        unexplained = error - model(correction)
        left = model(best) + unexplained
        for _ in range(self.steps):
            about, before = model.about(program.offsets(best), model.robot, NEARBY), _size(left)
            for _ in range(TRIES):
                tried = best + damped_step(program, damped(about, rho), left)
                rho *= 4.0
                if np.linalg.norm(program.offsets(tried), axis=1).max() > LARGEST_OFFSET:
                    continue
                residual = model(tried) + unexplained
                if _size(residual) < _size(left):
                    best, left, rho = tried, residual, rho / 12.0
                    break
            if _size(left) > WORTH * before:
                break
        return best


def model_of(law: Simulated) -> Model:
    """Raises TypeError for a law on another simulation."""
    if isinstance(law.simulation, Model):
        return law.simulation
    raise TypeError(f"no model of a program: {law.simulation}")


def _size(residual: Array) -> float:
    return float(np.sqrt(np.square(residual).mean()))


def law_of(model: Model, passes: int = PASSES) -> Refined:
    """Learning on the model between two runs of the robot."""
    step = TargetStep(model)
    return Refined(simulation=model, law=step, weight=AXES, by_rms=True, passes=passes)


def contour_measure(
    program: PlannedProgram, measure: Measure, robot: RobotModel | None = None
) -> Callable[[Pass], ContourOutput]:
    """Contour errors by a measure of the cut, set up by a first run.

    robot: that targets are learned on; None: the nominal one on the springs that the measure
    assumes or identifies. Raises ValueError for a measure that programs cannot be learned from.
    """
    experiment = program.experiment
    nominal, start = experiment.nominal, experiment.programmed[0]
    if isinstance(measure, MotorAngles):
        pose = kinematics.compile(experiment.cut.cell.robot).pose
        asked = program.run(program.rows(np.zeros((program.ends[-1], 3))))
        at = (asked.run_time, asked.plan_time)

        def commanded(phi: Array) -> Array:
            return np.ascontiguousarray(pose(np.ascontiguousarray(phi))[:, :3, 3])

        shift = experiment.programmed - at_plan(program, commanded(asked.reference), *at)

        def by_motors(run: Pass) -> Array:
            log = run.recording
            assert run.clock is not None
            own = [np.interp(run.of_motion(log.time), experiment.motion.time, c) for c in shift.T]
            return across(program, commanded(log.motor_angle) + np.stack(own, axis=1), *run.clock)

        model = Model(program, robot or nominal)
        return lambda first: ContourOutput(program, by_motors, law_by(as_run(model, first)))
    if isinstance(measure, ScannedPart):
        return _by_scan(program, measure, robot)
    if not isinstance(measure, ToolPath):
        raise ValueError(f"programs are learned from motors or the tool, not from {measure}")
    set_up = measure.prepare(experiment)

    def ready(first: Pass) -> ContourOutput:
        output = set_up(first)
        assert isinstance(output, ToolOutput)

        def position(run: Pass) -> tuple[Array, Array]:
            if measure.source is not Source.ESTIMATE:
                seen = run.tracker.valid if measure.source is Source.TRACKER else np.ones(2)
                at = run.tracker.time[: len(seen)]
                return start + output(run)[:, :3], np.interp(run.recording.time, at, seen)
            found = output.estimated(run)
            return start + found.displacement[:, :3], validity(found, run.recording.time).weight

        def by_tool(run: Pass) -> Array:
            tool, valid = position(run)
            assert run.clock is not None
            weight = at_plan(program, valid[:, np.newaxis], *run.clock)
            return across(program, tool, *run.clock) * weight

        model = Model(program, robot or _known(experiment, output.known.parameters.springs))
        return ContourOutput(program, by_tool, law_by(as_run(model, first)), output)

    return ready


def _by_scan(
    program: PlannedProgram, measure: ScannedPart, robot: RobotModel | None
) -> Callable[[Pass], ContourOutput]:
    """By the scan of each part, at the motors' path as it was at the instants of the plan."""
    experiment = program.experiment
    set_up, motion = measure.prepare(experiment), experiment.motion
    weight = np.where(motion.is_on_contour(motion.time), 1.0, 0.0)[:, np.newaxis]

    def planned(run: Pass) -> Pass:
        assert run.clock is not None
        log = run.recording
        names = ("reference", "correction", "motor_angle", "motor_torque")
        signals = {name: at_plan(program, getattr(log, name), *run.clock) for name in names}
        return replace(run, recording=replace(log, time=motion.time, **signals))

    def ready(first: Pass) -> ContourOutput:
        output = set_up(planned(first))
        assert isinstance(output, ScanOutput)

        def by_scan(run: Pass) -> Array:
            return -weight * output.across(planned(run))

        known = experiment.nominal if not output.springs else _known(experiment, output.springs)
        model = as_run(Model(program, robot or known), first)
        return ContourOutput(program, by_scan, law_by(model), output)

    return ready


@dataclass(frozen=True, kw_only=True, eq=False)
class Confirmed(Guarded):
    """A guarded law that is refined once its model has predicted what a run brought, and as long as
    it does: by another interpolator than assumed refined steps leave more than passes alone."""

    law: Refined

    def size(self, error: Array) -> float:
        """RMS in the plane: heights, which may be most of an error, do not hide that it grows."""
        up = model_of(self.law).program.experiment.motion.plane.axes[:, 2]
        return _size(error - np.outer(error @ up, up))

    def step(
        self, correction: Array, error: Array, memory: Best | None = None, /
    ) -> tuple[Array, Best]:
        if self._predicted(correction, error, memory):
            return super().step(correction, error, memory)
        alone = replace(self, law=replace(self.law, steps=0))
        return super(Confirmed, alone).step(correction, error, memory)

    def _predicted(self, correction: Array, error: Array, memory: Best | None) -> bool:
        """From the best run before to this one."""
        if memory is None:
            return False
        model = self.law.simulation
        said = model(correction) - model(memory.correction)
        missed = error - memory.error - said
        return float(np.linalg.norm(missed)) < MISSED * float(np.linalg.norm(said))


def law_by(model: Model) -> Law:
    """The law on a model, which goes back to its best run where errors grow."""
    return Confirmed(law=law_of(model), weight=AXES)


def _known(experiment: Experiment[Any], springs: Elasticity) -> RobotModel:
    """The nominal robot on the springs of gears that are assumed, or identified."""
    nominal = experiment.nominal
    individual = Individual(
        gear_stiffness=springs.stiffness[springs.axes] / nominal_arm(nominal).stiffness
    )
    return embodied(nominal, individual, available(nominal), phi=experiment.loaded.reference[0])


def learn_targets(
    program: PlannedProgram,
    measure: Measure,
    iterations: int,
    *,
    start: Start | None = None,
    robot: RobotModel | None = None,
    converged: float | None = None,
    plant: ProgramPlant | None = None,
) -> Iterator[Iteration]:
    """Runs k = 0 .. `iterations` of a program whose targets are learned.

    Corrections are displacements of the path (N, 3) [m]. robot: as of `contour_measure`. plant:
    runs the program in place of the virtual robot. Raises as `contour_measure` and `iterate`.
    """
    return iterate(
        program.experiment,
        contour_measure(program, measure, robot),
        iterations,
        plant=plant or ProgramPlant.of(program),
        start=start,
        converged=converged,
        inputs=3,
    )


def learned_in(program: PlannedProgram, robot: RobotModel) -> Array:
    """Displacement of the path (N, 3) [m] that a model of the robot, such as a twin, needs."""
    model, none = Model(program, robot), np.zeros((len(program.experiment.motion.time), 3))
    return law_of(model, 2 * PASSES)(none, model(none))
