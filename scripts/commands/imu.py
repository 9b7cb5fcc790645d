"""`armside imu`: a robot moves with an IMU on its tool; the kinematics predict what it measures."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.sim.cell import CELLS, Cell
from armside.sim.imu import Compensation, Order, ProcessingCfg, Scheme
from armside.sim.imu.experiment import (
    WINDOW,
    Evaluation,
    ImuRun,
    Measures,
    evaluate,
    measure,
    sense,
    synchronised_at,
    without_feedforward,
)
from armside.sim.imu.vibration import Rest, at_rest, lines
from armside.sim.instruments.imu import ACCELEROMETER, GYROSCOPE, ImuCfg
from armside.sim.moves.planner import JointMotion, plan_program
from armside.sim.moves.program_file import read_program
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.linkage import checked_loop_error
from armside.sim.robot.model import RobotModel, load_model
from armside.sim.robot.recording import Recording
from armside.sim.robot.virtual_robot import LOG_PERIOD, Job, VirtualRobot

from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common, options

REST_POSE = np.zeros(6)
"""Thesis 5.1.1 measures in the zero pose."""


@options
@dataclass(frozen=True, kw_only=True)
class ImuExperimentCfg:
    """How the robot moves, and how measurement and prediction are made comparable."""

    robot: Literal["irb1400", "large"] = "irb1400"
    """Which robot."""
    motion: Literal["simultaneous", "sequential", "rest"] = "simultaneous"
    """All motors at once, one at a time, or none: motors off, then on."""
    program: Path | None = None
    """Motion program (TOML) in place of that motion's own."""
    flexibility: Literal["full", "gears", "rigid"] = "full"
    """What of the robot gives way: gears and structure, gears only, or nothing."""
    servo: Literal["feedforward", "pid"] = "feedforward"
    """Whether the servo anticipates the torque of the motion."""
    off: float = 25.0
    """At rest: seconds with the motors off [s]."""
    on: float = 25.0
    """At rest: seconds with the motors on [s]."""
    cutoff: float = 5.0
    """Zero-phase low-pass of both sides [Hz]."""
    order: Literal["filter-then-map", "map-then-filter"] = "filter-then-map"
    """Whether joint rates are filtered (thesis) or what they predict."""
    differences: Literal["forward", "central"] = "forward"
    """Difference quotient of motor angles: (5.6) of the thesis, half a sample early, or central."""
    compensation: Literal["actual-orientation", "mean-at-rest"] = "actual-orientation"
    """Gravity and offsets: by the orientation of every sample, or by the mean at rest (thesis)."""
    accelerometer_delay: float = round(1e3 * ACCELEROMETER.delay, 3)
    """Delay of the accelerometer's low-pass that is compensated [ms]."""
    gyroscope_delay: float = round(1e3 * GYROSCOPE.delay, 3)
    """Delay of the gyro's low-pass that is compensated [ms]."""

    def __post_init__(self) -> None:
        for name, unit in (("off", "s"), ("on", "s"), ("cutoff", "Hz")):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} must be > 0 {unit}, got {getattr(self, name):g}")
        for name in ("accelerometer_delay", "gyroscope_delay"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise ValueError(f"{name} must be >= 0 ms, got {getattr(self, name):g}")
        if self.cutoff >= 0.5 * ImuCfg().rate:
            raise ValueError(
                f"cutoff must be below {0.5 * ImuCfg().rate:g} Hz, got {self.cutoff:g}"
            )
        if self.motion == "rest" and self.program is not None:
            raise ValueError("program and motion rest exclude each other")
        if self.motion == "rest" and min(self.off, self.on) < 3.0:
            raise ValueError("off and on must be at least 3 s for a spectrum")


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """One program, loaded into the robot."""

    name: str
    job: Job
    since: float
    """End of the synchronisation [s]."""
    motion: JointMotion


@dataclass(frozen=True, kw_only=True)
class Done:
    """One program, run and evaluated."""

    prepared: Prepared
    run: ImuRun
    evaluation: Evaluation
    measures: Measures


def robot_model(cfg: ImuExperimentCfg) -> RobotModel:
    """The robot of the options."""
    model = load_model(variant(CELLS[cfg.robot].xml, Flexibility(cfg.flexibility)))
    return model if cfg.servo == "feedforward" else without_feedforward(model)


def processing(cfg: ImuExperimentCfg) -> ProcessingCfg:
    """How the options process the signals."""
    return ProcessingCfg(
        cutoff=cfg.cutoff,
        order=Order(cfg.order),
        scheme=Scheme(cfg.differences),
        compensation=Compensation(cfg.compensation),
        accelerometer_delay=1e-3 * cfg.accelerometer_delay,
        gyroscope_delay=1e-3 * cfg.gyroscope_delay,
    )


def prepare(cfg: ImuExperimentCfg) -> list[Prepared]:
    """Read, plan and load the programs; raises ValueError for what cannot be done."""
    cell = CELLS[cfg.robot]
    robot = VirtualRobot(robot_model(cfg))
    return [_prepared(path, cell, robot) for path in _program_files(cfg, cell)]


def _program_files(cfg: ImuExperimentCfg, cell: Cell) -> tuple[Path, ...]:
    if cfg.program is not None:
        return (cfg.program,)
    if cfg.motion not in cell.programs:
        known = ", ".join(cell.programs)
        raise ValueError(f"motion {cfg.motion!r} has no program for {cfg.robot}. It has: {known}")
    return cell.programs[cfg.motion]


def _prepared(path: Path, cell: Cell, robot: VirtualRobot) -> Prepared:
    program = read_program(path)
    motion = plan_program(program, cell.robot, cell.limits, step=LOG_PERIOD)
    return Prepared(
        name=path.stem,
        job=robot.load(motion.phi),
        since=synchronised_at(program, motion),
        motion=motion,
    )


def run_one(cfg: ImuExperimentCfg, prepared: Prepared, seed: int) -> Done:
    """Run one program and evaluate it."""
    cell = CELLS[cfg.robot]
    run = sense(prepared.job, ImuCfg(), seed)
    evaluation = evaluate(run, cell.robot, cell.with_imu, processing(cfg))
    measures = measure(run, evaluation, prepared.job.model.mj, since=prepared.since)
    return Done(prepared=prepared, run=run, evaluation=evaluation, measures=measures)


def run(cfg: ImuExperimentCfg, seed: int) -> dict[str, Any]:
    """Prepare, run and evaluate a motion, as `summary.json` has it."""
    return results([run_one(cfg, prepared, seed) for prepared in prepare(cfg)])


def results(done: list[Done]) -> dict[str, Any]:
    """Measures, limits and moves of each program."""
    return {
        "limits_hit": [
            {"k": k, "limit": name, "axis": axis, "time": time}
            for k, one in enumerate(done)
            for name, axis, time in one.run.recording.limits_hit
        ],
        "experiments": [
            {
                "k": k,
                "program": one.prepared.name,
                "duration": float(one.run.recording.time[-1]),
                "moves": [asdict(report) for report in one.prepared.motion.reports],
            }
            | asdict(one.measures)
            for k, one in enumerate(done)
        ],
    }


AS_THE_THESIS: dict[str, Any] = {
    "compensation": "mean-at-rest",
    "accelerometer_delay": round(1e3 * GYROSCOPE.delay, 3),
}
"""Gravity by the mean at rest, and clocks synchronised by one sensor for both."""


BEST: dict[str, Any] = {"order": "map-then-filter", "differences": "central"}
"""Both sides filtered alike, and no shift between rate and angle."""


def causes(cfg: ImuExperimentCfg, seed: int) -> Iterator[tuple[str, Measures]]:
    """What the acceleration error is made of: each cause switched off or on by itself."""
    base = run_one(cfg, prepare(cfg)[0], seed)
    yield "as chosen", base.measures
    for name, change in (
        ("processed as in the thesis", AS_THE_THESIS),
        ("sensor delays left in", {"accelerometer_delay": 0.0, "gyroscope_delay": 0.0}),
        ("central differences", {"differences": "central"}),
        ("mapped, then filtered", {"order": "map-then-filter"}),
        ("both", BEST),
        ("gravity by the mean at rest", {"compensation": "mean-at-rest"}),
    ):
        yield name, evaluated_again(replace(cfg, **change), base)
    rigid = replace(cfg, flexibility="rigid")
    stiff = run_one(rigid, prepare(rigid)[0], seed)
    yield "rigid robot", stiff.measures
    yield "rigid robot, both", evaluated_again(replace(rigid, **BEST), stiff)


def processed_again(cfg: ImuExperimentCfg, done: Done) -> Done:
    """A run, processed by other options."""
    cell, prepared = CELLS[cfg.robot], done.prepared
    evaluation = evaluate(done.run, cell.robot, cell.with_imu, processing(cfg))
    measures = measure(done.run, evaluation, prepared.job.model.mj, since=prepared.since)
    return replace(done, evaluation=evaluation, measures=measures)


def evaluated_again(cfg: ImuExperimentCfg, done: Done) -> Measures:
    """Measures of a run, processed by other options."""
    return processed_again(cfg, done).measures


def imu_position(cfg: ImuExperimentCfg, recording: Recording) -> Array:
    """(N, 3) [m], of the IMU in base axes, by D-H from the logged motor angles."""
    angle = np.ascontiguousarray(recording.motor_angle)
    return kinematics.compile(CELLS[cfg.robot].with_imu).pose(angle)[:, :3, 3]


def imu(*, cfg: ImuExperimentCfg = ImuExperimentCfg(), common: Common = Common()) -> None:
    """Move a robot with an IMU on its tool and predict what the IMU measures.

    Writes summary.json, signals.parquet, imu.parquet, replay.rrd and figures as PNG.
    """
    report = Report(common)
    if cfg.motion == "rest":
        _rest(cfg, common, report)
        return
    with checking_input():
        prepared = prepare(cfg)
    with report.progress("moving", total=len(prepared)) as step:
        done = list(_each(cfg, prepared, common.seed, step))
    outcome = summary("imu", cfg, common, **results(done))
    with RunFolder("imu", seed=common.seed, out=common.out) as folder:
        _write(folder, cfg, done, outcome)
    _print(report, done)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _each(
    cfg: ImuExperimentCfg, prepared: list[Prepared], seed: int, step: Callable[[], None]
) -> Iterator[Done]:
    for one in prepared:
        yield run_one(cfg, one, seed)
        step()


def _write(
    folder: RunFolder, cfg: ImuExperimentCfg, done: list[Done], outcome: dict[str, Any]
) -> None:
    from armside.sim.imu.replay import write_imu_replay
    from armside.sim.imu.signals import write_imu_signals
    from armside.sim.records.signals import RecordedRun, write_signals

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    config = outcome["config"]
    runs = [RecordedRun(k=k, recording=one.run.recording) for k, one in enumerate(done)]
    write_signals(folder / "signals.parquet", runs, config=config, seed=config["seed"])
    pairs = [(one.run, one.evaluation) for one in done]
    write_imu_signals(folder / "imu.parquet", pairs, config=config)
    _write_robot(folder, cfg)
    write_imu_replay(folder / "replay.rrd", done[0].prepared.job.model.mj, pairs)
    for one in done:
        suffix = f"-{one.prepared.name}" if len(done) > 1 else ""
        _draw(folder, cfg, one, suffix)


def _write_robot(folder: RunFolder, cfg: ImuExperimentCfg) -> None:
    """Write the robot with which `armside replay` draws the run."""
    import mujoco

    from armside.sim.records.robot_file import write_robot
    from armside.sim.robot.flexibility import without

    spec = mujoco.MjSpec.from_file(str(CELLS[cfg.robot].xml))
    without(spec, Flexibility(cfg.flexibility))
    write_robot(folder / "robot.xml", spec)


def _draw(folder: RunFolder, cfg: ImuExperimentCfg, one: Done, suffix: str) -> None:
    from ..figures import imu as figures

    recording, evaluation = one.run.recording, one.evaluation
    comparison = evaluation.comparison
    angles = folder / f"motor-angles{suffix}.png"
    figures.motor_angles(angles, recording.time, recording.motor_angle)
    figures.path(folder / f"path{suffix}.png", imu_position(cfg, recording))
    figures.position(
        folder / f"position{suffix}.png",
        recording.time,
        evaluation.tool,
        evaluation.tool_predicted,
    )
    figures.measured_and_predicted(
        folder / f"angular-velocity{suffix}.png",
        comparison.time,
        comparison.angular_velocity_measured,
        comparison.angular_velocity_predicted,
        "Angular velocity of the IMU, base axes",
        "ω",
        "rad/s",
    )
    figures.measured_and_predicted(
        folder / f"acceleration{suffix}.png",
        comparison.time,
        comparison.acceleration_measured,
        comparison.acceleration_predicted,
        "Linear acceleration of the IMU, base axes",
        "a",
        "m/s²",
    )
    late = comparison.time >= one.prepared.since
    figures.acceleration_error(
        folder / f"acceleration-error{suffix}.png",
        comparison.time[late],
        {"": evaluation.window_rms[late]},
        WINDOW,
    )


def _print(report: Report, done: list[Done]) -> None:
    for one in done:
        m = one.measures
        rows = [
            ("angular velocity error, RMS [mrad/s]", *(1e3 * m.angular_velocity_rms)),
            ("angular velocity error, largest [mrad/s]", *(1e3 * m.angular_velocity_max)),
            ("acceleration error, RMS [m/s²]", *m.acceleration_rms),
            (f"acceleration error, largest RMS over {WINDOW:g} s", *m.acceleration_window_max),
            ("  at [s]", *m.acceleration_window_time),
            ("acceleration, largest [m/s²]", *m.acceleration_peak),
        ]
        rows = [(name, *map(float, values)) for name, *values in rows]
        report.table(one.prepared.name, ["from the end of synchronisation", *"xyz"], rows)
        report.line(
            f"clocks: {1e3 * one.evaluation.comparison.clock_offset:.2f} ms apart, found within "
            f"{1e3 * abs(m.clock_offset_error):.2f} ms; tool to motor-angle D-H: at most "
            f"{1e3 * m.tool_distance:.2f} mm; loop open by {1e6 * m.loop_error:.3f} µm; "
            f"{100 * m.clipped_share:.1f} % clipped"
        )
        if np.isfinite(m.idle_peaks).any():
            peaks = ", ".join("-" if np.isnan(p) else f"{1e4 * p:.1f}" for p in m.idle_peaks)
            report.line(f"idle motors pushed by others: {peaks} × 1e-4 rad")
        for move in one.prepared.motion.reports:
            if move.limited_by and move.programmed.path is not None:
                report.line(
                    f"move at {move.start:.2f} s: {move.reached:.2f} of "
                    f"{move.programmed.path:.2f} m/s, limited by {move.limited_by}"
                )


def run_rest(cfg: ImuExperimentCfg, seed: int) -> tuple[ImuRun, Rest]:
    """The robot in its zero pose: motors off, then on."""
    n = round((cfg.off + cfg.on) / LOG_PERIOD) + 1
    job = VirtualRobot(robot_model(cfg)).load(np.tile(REST_POSE, (n, 1)), motors_on_at=cfg.off)
    sensor = replace(ImuCfg(), clock_offset=0.0)
    run = sense(job, sensor, seed)
    return run, at_rest(run.samples, cfg.off, sensor.rate)


def _rest(cfg: ImuExperimentCfg, common: Common, report: Report) -> None:
    with checking_input():
        if cfg.robot != "irb1400":
            raise ValueError(f"motion rest needs brakes, which robot {cfg.robot} lacks")
    run, rest = run_rest(cfg, common.seed)
    mj = robot_model(cfg).mj
    qpos = run.recording.truth.qpos[:: round(LOG_PERIOD / mj.opt.timestep)]
    outcome = summary(
        "imu",
        cfg,
        common,
        rest={
            "off_rms": rest.off_rms,
            "on_rms": rest.on_rms,
            "on_level": rest.on_level,
            "loop_error": checked_loop_error(mj, qpos),
            "lines": {
                axis: lines(rest.frequency, rest.on_spectrum[:, i])[:5]
                for i, axis in enumerate("xyz")
            },
        },
    )
    with RunFolder("imu", seed=common.seed, out=common.out) as folder:
        _write_rest(folder, cfg, run, rest, outcome)
    report.table(
        "Acceleration at rest [m/s²]",
        ["", *"xyz"],
        [
            ("motors off, RMS", *map(float, rest.off_rms)),
            ("motors on, RMS", *map(float, rest.on_rms)),
            ("motors on, exceeded by 0.3 %", *map(float, rest.on_level)),
        ],
    )
    report.line(f"Results in {folder.path}")
    report.summary(outcome)


def _write_rest(
    folder: RunFolder, cfg: ImuExperimentCfg, run: ImuRun, rest: Rest, outcome: dict[str, Any]
) -> None:
    from armside.sim.records.signals import RecordedRun, write_signals

    from ..figures import imu as figures

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    config = outcome["config"]
    runs = [RecordedRun(k=0, recording=run.recording)]
    write_signals(
        folder / "signals.parquet", runs, config=config, seed=config["seed"], truth_rate=250.0
    )
    _write_robot(folder, cfg)
    figures.rest(folder / "rest.png", run.samples.time, run.samples.acceleration, cfg.off)
    figures.spectrum(folder / "spectrum.png", rest.frequency, rest.off_spectrum, rest.on_spectrum)
