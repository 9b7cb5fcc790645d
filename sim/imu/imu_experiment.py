"""The IMU experiment: plan a motion, run it, compare measured with predicted motion."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuCfg, draw
from ..motion.planner import ProgramMotion, plan_program, slower_moves
from ..notes import Cause, Note, together
from ..robot.flexibility import Flexibility
from ..robot.recording import Recording, saturation
from ..robot.run import LoadedReference
from ..robot.virtual_robot import VirtualRobot
from .imu_specification import ImuExperiment
from .measured_beside_predicted import find_offset
from .phases import (
    RECTANGLE,
    SLOW_CIRCLE,
    Evaluation,
    ImuRun,
    Measures,
    evaluate,
    measure,
    position,
    synchronised_at,
    under_way,
)
from .predicted_motion import Compensation, Order, ProcessingCfg, Scheme


@dataclass(frozen=True)
class PlannedProgram:
    """One motion program, planned and loaded into the robot."""

    name: str
    loaded: LoadedReference
    motion: ProgramMotion
    since: float
    """End of the synchronisation [s]."""


@dataclass(frozen=True)
class ImuResult:
    """One program, run and evaluated."""

    experiment: ImuExperiment
    planned: PlannedProgram
    run: ImuRun
    evaluation: Evaluation
    measures: Measures

    @property
    def imu_position(self) -> Array:
        """(N, 3) [m], IMU in base axes by D-H from the logged motor angles."""
        return position(self.experiment.cell.with_imu, self.run.recording.motor_angle)

    @property
    def fast_over_slow(self) -> float:
        """RMS of the acceleration error in the rectangle over that in the slow circle."""
        comparison, motion = self.evaluation.comparison, self.planned.motion
        parts = (under_way(motion, comparison.time, v) for v in (RECTANGLE, SLOW_CIRCLE))
        fast, slow = (np.sqrt(np.mean(comparison.acceleration_error[part] ** 2)) for part in parts)
        return float(fast / slow)

    @property
    def largest_in_rectangle(self) -> np.ndarray:
        """(3,) bool, axes whose largest moving RMS of the error lies in the rectangle."""
        return under_way(self.planned.motion, self.measures.acceleration_window_time, RECTANGLE)


def prepare(experiment: ImuExperiment) -> list[PlannedProgram]:
    """Read, plan and load the motion programs. Raises ValueError or OSError for a program that is
    wrong, unreachable or missing."""
    cell, model = experiment.cell, experiment.model()
    robot, planned = VirtualRobot(model), list[PlannedProgram]()
    for name, program in experiment.programs(model).items():
        motion = plan_program(program, cell.robot, cell.limits)
        since = synchronised_at(program, motion)
        planned.append(PlannedProgram(name, robot.load(motion.phi), motion, since))
    return planned


def run_imu(experiment: ImuExperiment, seed: int = 0) -> list[ImuResult]:
    """Run and evaluate an experiment: one result a program, two in a sequential motion.

    seed: of the robot's noise and of the IMU individual.
    """
    return [run_one(experiment, planned, seed) for planned in prepare(experiment)]


def run_one(experiment: ImuExperiment, planned: PlannedProgram, seed: int) -> ImuResult:
    """Run one program and evaluate it."""
    return _evaluated(experiment, planned, sense(planned.loaded, experiment.imu, seed))


def reprocessed(result: ImuResult, processing: ProcessingCfg) -> ImuResult:
    """The same run with other processing."""
    experiment = replace(result.experiment, processing=processing)
    return _evaluated(experiment, result.planned, result.run)


def _evaluated(experiment: ImuExperiment, planned: PlannedProgram, run: ImuRun) -> ImuResult:
    mj = planned.loaded.model.mj
    evaluation = evaluate(run, experiment.cell, experiment.processing, -mj.opt.gravity)
    measures = measure(run, evaluation, mj, since=planned.since)
    return ImuResult(experiment, planned, run, evaluation, measures)


def sense(loaded: LoadedReference, cfg: ImuCfg, seed: int) -> ImuRun:
    """Run a loaded reference once with an IMU on the tool; seed: of the robot's noise and of the
    IMU individual, in separate streams."""
    of_robot, of_imu = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    return _measured(loaded.run(rng=of_robot), cfg, of_imu)


def _measured(recording: Recording, cfg: ImuCfg, rng: np.random.Generator) -> ImuRun:
    imu, truth = draw(cfg, rng), recording.truth
    samples = imu.measure(truth.time, truth.imu_acceleration, truth.imu_angular_velocity, rng)
    return ImuRun(recording=recording, samples=samples, imu=imu)


def clock_errors(
    result: ImuResult, rngs: Sequence[np.random.Generator], *, apart: float = 0.4
) -> Array:
    """Errors of the clock offset (n,) [s] for other IMU individuals on the same run, whose clocks
    are up to `apart` [s] off: as far as a start by hand may be."""
    recording, experiment = result.run.recording, result.experiment
    log, robot = (recording.time, recording.motor_angle), experiment.cell.with_imu
    cfg, errors = replace(experiment.imu, clock_offset=apart), []
    for rng in rngs:
        run = _measured(recording, cfg, rng)
        found = find_offset(run.samples, *log, robot, experiment.processing)
        errors.append(found - run.imu.clock_offset)
    return np.array(errors)


def results(runs: Sequence[ImuResult]) -> dict[str, Any]:
    """Entries of `summary.json`: limits, moves and measures of each program."""
    return {
        "limits_hit": [
            {"k": k, "limit": name, "axis": axis, "time": time}
            for k, one in enumerate(runs)
            for name, axis, time in one.run.recording.limits_hit
        ],
        "experiments": [
            {
                "k": k,
                "program": one.planned.name,
                "duration": float(one.run.recording.time[-1]),
                "moves": [asdict(report) for report in one.planned.motion.reports],
            }
            | asdict(one.measures)
            for k, one in enumerate(runs)
        ],
    }


def notes(runs: Sequence[ImuResult]) -> list[Note]:
    """Notes of all programs, each once with the runs that it concerns."""
    found = []
    for k, one in enumerate(runs):
        samples = one.run.samples
        own = [*slower_moves(one.planned.motion), *saturation(one.run.recording)]
        for name, clipped in (
            ("accelerometer", samples.acceleration_clipped),
            ("gyro", samples.angular_velocity_clipped),
        ):
            if clipped.any():
                fraction = 100.0 * float(clipped.any(axis=1).mean())
                text = f"{fraction:.2g} % of the {name}'s samples are clipped at its range"
                own.append(Note(cause=Cause.IMU, text=text))
        found += [note.at(k) for note in own]
    return together(found)


def causes(
    experiment: ImuExperiment, seed: int, each: Callable[[ImuResult], None] = lambda run: None
) -> Iterator[tuple[str, Measures]]:
    """Measures of the first program with each cause of the error changed, by its name; `each` is
    called with the two runs, which the others process again."""
    cfg = experiment.processing
    base = run_one(experiment, prepare(experiment)[0], seed)
    each(base)
    yield "as chosen", base.measures
    for name, processing in (
        ("processed as in the thesis", cfg.as_in_the_thesis),
        ("sensor delays left in", replace(cfg, accelerometer_delay=0.0, gyroscope_delay=0.0)),
        ("central differences", replace(cfg, scheme=Scheme.CENTRAL)),
        ("mapped, then filtered", replace(cfg, order=Order.MAP_THEN_FILTER)),
        ("both", cfg.best),
        ("gravity by the mean at rest", replace(cfg, compensation=Compensation.MEAN_AT_REST)),
    ):
        yield name, reprocessed(base, processing).measures
    rigid = replace(experiment, flexibility=Flexibility.RIGID)
    stiff = run_one(rigid, prepare(rigid)[0], seed)
    each(stiff)
    yield "rigid robot", stiff.measures
    yield "rigid robot, both", reprocessed(stiff, cfg.best).measures
