"""`armside laser`: a robot cuts a shape, ILC improves it, a laser tracker judges."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import numpy as np
from cyclopts import Parameter

from ilc import measures
from ilc.filters import ZeroPhaseButterworth
from ilc.laws import Heuristic
from sim import experiment as experiments
from sim.cell import CELLS
from sim.effects import Effect
from sim.experiment import CircleTask, Experiment, Iteration
from sim.model import load_model
from sim.motion.poses import pose
from sim.motion.timing import PathLimits
from sim.robot import LOG_PERIOD

from .console import Report
from .errors import RunFailed, checking_input
from .options import Common, options
from .run_folder import RunFolder
from .summary import dumps, summary

if TYPE_CHECKING:
    from sim.arm_learning import ArmLearningCfg

Number = TypeVar("Number", int, float)
_Several = Parameter(consume_multiple=True)
SMALLEST_RADIUS = 0.1
"""[mm]; a smaller circle is below what a robot of this size resolves."""
EffectName = Literal["lost-motion", "gear-error", "ripple", "load-friction"]


@options
@dataclass(frozen=True, kw_only=True)
class LaserCfg:
    """What to cut, with which robot, and how to learn it."""

    robot: Literal["large", "irb1400"] = "large"
    """Which robot."""
    model: Path | None = None
    """MJCF file to use in place of that robot's own."""
    pose: str = "p1"
    """Where: p1, p2 or p3 of thesis (9.3), or those of the other robot."""
    shape: Literal["circle"] = "circle"
    """What to cut."""
    radius: float = 5.0
    """Programmed radius [mm]."""
    speed: float = 40.0
    """Programmed speed along the path [mm/s]."""
    plane: Literal["base-xy", "tool"] = "base-xy"
    """Plane of the shape: the base x-y plane, or perpendicular to the tool axis."""
    law: Literal["auto", "heuristic", "inverse", "norm-optimal"] = "auto"
    """Learning law: heuristic is Q(u + gamma q^delta e), thesis (9.2); the others invert a model of
    the arm [auto: heuristic for --measure motor, inverse otherwise]."""
    measure: Literal["motor", "estimate", "tracker"] = "motor"
    """What is learned from: motor angles, the tool as estimated with an IMU, or as tracked."""
    gamma: Annotated[tuple[float, ...], _Several] = (0.9,)
    """Learning gain, one for all motors or six."""
    delta: Annotated[tuple[int, ...], _Several] = (3,)
    """Time shift [samples of 4 ms], one for all motors or six."""
    cutoff: Annotated[tuple[float, ...], _Several] = (10.0,)
    """Cutoff of Q [Hz], one for all motors or six."""
    iterations: int = 5
    """Number of updates; one run more is made."""
    path_acceleration: float = 1.3
    """Limit of the controller for acceleration along and across the path [m/s^2]."""
    stiffness_error: float = 30.0
    """Stiffness is believed wrongly by up to this, each axis; drawn with the seed [%]."""
    identification: Path | None = None
    """Folder of `armside identify` at this pose, in place of identifying from the first run."""
    on_imu_fault: Literal["refuse", "go-on"] = "refuse"
    """When the IMU cannot be used: do not learn, or go on with motor angles and model alone."""
    without: Annotated[tuple[EffectName, ...], _Several] = ()
    """Effects of gears and drives to leave out, for ablations."""
    friction_spread: float = 2.0
    """Friction of this individual: uniform within +- this part of nominal, each axis [%]."""

    def __post_init__(self) -> None:
        for name, unit in (("radius", "mm"), ("speed", "mm/s")):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be > 0 {unit}, got {value:g}")
        if self.radius < SMALLEST_RADIUS:
            raise ValueError(f"radius must be >= {SMALLEST_RADIUS:g} mm, got {self.radius:g}")
        if self.iterations < 0:
            raise ValueError(f"iterations must be >= 0, got {self.iterations}")
        for name in ("friction_spread", "stiffness_error"):
            if not 0.0 <= getattr(self, name) < 100.0:
                said = name.replace("_", "-")
                raise ValueError(f"{said} must be in [0, 100) %, got {getattr(self, name):g}")
        if not self.path_acceleration > 0.0:
            raise ValueError(f"path-acceleration must be > 0 m/s^2, got {self.path_acceleration:g}")
        for name in ("gamma", "delta", "cutoff"):
            if len(getattr(self, name)) not in (1, 6):
                raise ValueError(f"{name} takes one value or six, got {len(getattr(self, name))}")
        if self.measure == "motor" and self.law not in ("auto", "heuristic"):
            raise ValueError(f"law {self.law} needs --measure estimate or tracker")
        learning_law(self)
        if self.measure != "motor":
            arm_learning(self)


def arm_learning(cfg: LaserCfg) -> "ArmLearningCfg":
    """How to learn on the arm side. Raises ValueError where options are out of range."""
    from sim.arm_learning import ArmLaw, ArmLearningCfg, Measure, OnFault

    for name in ("gamma", "delta", "cutoff"):
        if len(getattr(cfg, name)) > 1:
            raise ValueError(f"{name} takes one value with --measure {cfg.measure}")
    return ArmLearningCfg(
        measure=Measure(cfg.measure),
        law=ArmLaw("inverse" if cfg.law == "auto" else cfg.law),
        gamma=cfg.gamma[0],
        delta=cfg.delta[0],
        cutoff=cfg.cutoff[0],
        on_fault=OnFault(cfg.on_imu_fault),
    )


def learning_law(cfg: LaserCfg) -> Heuristic:
    """The law of the options. Raises ValueError where they are out of range."""
    Q = ZeroPhaseButterworth(_shared(cfg.cutoff), LOG_PERIOD)
    return Heuristic(Q=Q, gamma=_shared(cfg.gamma), delta=_shared(cfg.delta))


def _shared(values: tuple[Number, ...]) -> Number | tuple[Number, ...]:
    """One value for all motors where one is given."""
    return values[0] if len(values) == 1 else values


def task(cfg: LaserCfg) -> CircleTask:
    """The task of the options, in SI units. Raises ValueError for an unknown pose."""
    return CircleTask(
        pose=pose(cfg.pose, CELLS[cfg.robot].poses),
        radius=cfg.radius * 1e-3,
        speed=cfg.speed * 1e-3,
        across_tool=cfg.plane == "tool",
        limits=PathLimits(acceleration=cfg.path_acceleration),
    )


def prepare(cfg: LaserCfg, seed: int) -> Experiment:
    """Everything before the first run; raises ValueError for what cannot be done."""
    cell = CELLS[cfg.robot]
    imu = None
    if cfg.measure != "motor":
        from sim.instruments.imu import ImuCfg

        imu = ImuCfg()
    experiment = experiments.prepare(
        cell,
        load_model(cfg.model or cell.xml),
        task(cfg),
        seed=seed,
        friction_spread=cfg.friction_spread * 1e-2,
        without=[Effect(name) for name in cfg.without],
        imu=imu,
    )
    learning_law(cfg).check(*experiment.job.reference.shape)
    return experiment


def run(cfg: LaserCfg, seed: int, done: Callable[[], None] = lambda: None) -> dict[str, Any]:
    """Prepare, run and learn: status, limits and measures, as `results` arranges them."""
    experiment = prepare(cfg, seed)
    start = _start(cfg, experiment, seed)
    return results(experiment, list(_counted(start(), done)))


def _start(cfg: LaserCfg, experiment: Experiment, seed: int) -> Callable[[], Iterable[Iteration]]:
    """What makes the runs, with all that it reads already read."""
    if cfg.measure == "motor":
        return lambda: experiments.iterate(experiment, learning_law(cfg), cfg.iterations)
    from .arm_side import believed_arm, stored_springs

    cell = CELLS[cfg.robot]
    source = cfg.model or cell.xml
    arm = believed_arm(source, cfg.stiffness_error * 1e-2, seed)
    springs = stored_springs(cfg.identification, cfg.pose) if cfg.identification else None

    def start() -> Iterable[Iteration]:
        from sim.arm_learning import begin
        from sim.instruments.imu import ImuCfg

        return begin(
            experiment,
            load_model(source),
            arm,
            ImuCfg(),
            arm_learning(cfg),
            cfg.iterations,
            springs,
        )[1]

    return start


def _counted(iterations: Iterable[Iteration], done: Callable[[], None]) -> Iterator[Iteration]:
    for iteration in iterations:
        yield iteration
        done()


def results(experiment: Experiment, iterations: list[Iteration]) -> dict[str, Any]:
    """Status, limits and measures of a run, as `summary.json` has them."""
    rows = [
        {
            "k": it.trial.k,
            "motor_inf": measures.inf_norm(it.motor_error),
            "motor_two": measures.two_norm(it.motor_error),
            "arm_rms": it.arm.rms,
            "arm_maxdev": it.arm.maxdev,
            "arm_rms_true": it.arm_true.rms,
            "arm_maxdev_true": it.arm_true.maxdev,
        }
        for it in iterations
    ]
    for row in rows:
        for name in ("motor_inf", "motor_two", "arm_rms", "arm_maxdev"):
            row[f"{name}_normalised"] = measures.normalise(row[name], rows[0][name])
    motion = experiment.motion
    return {
        "status": "diverged" if iterations[-1].trial.diverged else "done",
        "limits_hit": [
            {"k": None, "limit": name, "axis": axis, "time": time}
            for name, axis, time in motion.limits_hit
        ]
        + [
            {"k": it.trial.k, "limit": name, "axis": axis, "time": time}
            for it in iterations
            for name, axis, time in it.trial.result.recording.limits_hit
        ],
        "reached_speed": motion.reached_speed,
        "beam_lost": [not bool(it.trial.result.tracker.valid.all()) for it in iterations],
        "iterations": rows,
    }


def laser(*, cfg: LaserCfg = LaserCfg(), common: Common = Common()) -> None:
    """Cut a circle with a flexible robot and learn to cut it better, from motor or arm side.

    Writes summary.json, signals.parquet, circles.png, errors.png and replay.rrd.
    """
    report = Report(common)
    with checking_input():
        experiment = prepare(cfg, common.seed)
        start = _start(cfg, experiment, common.seed)
    with report.progress("cutting", total=cfg.iterations + 1) as step:
        iterations = list(_counted(start(), step))
    outcome = summary("laser", cfg, common, **results(experiment, iterations))
    with RunFolder("laser", seed=common.seed, out=common.out) as folder:
        _write(folder, experiment, iterations, outcome)
    _print(report, outcome, folder.path)
    if outcome["status"] == "diverged":
        raise RunFailed(f"learning diverged at iteration {iterations[-1].trial.k}")


def _write(
    folder: RunFolder, experiment: Experiment, iterations: list[Iteration], outcome: dict[str, Any]
) -> None:
    from sim.replay import write_replay
    from sim.signals import Run, write_signals

    from . import figures

    (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    runs = [
        Run(k=it.trial.k, recording=it.trial.result.recording, tracker=it.trial.result.tracker)
        for it in iterations
    ]
    config = outcome["config"]
    write_signals(folder / "signals.parquet", runs, config=config, seed=config["seed"])
    robot = CELLS[config["robot"]].robot
    write_replay(folder / "replay.rrd", experiment.job.model.mj, runs, experiment.motion, robot)
    rows = outcome["iterations"]
    curve = experiment.task.curve
    figures.circles(
        folder / "circles.png",
        curve.point(np.linspace(0.0, curve.length, 361)),
        [it.arm.path for it in iterations],
        rms=[row["arm_rms"] for row in rows],
        maxdev=[row["arm_maxdev"] for row in rows],
    )
    figures.errors(
        folder / "errors.png",
        np.array([row["motor_inf_normalised"] for row in rows]),
        [row["arm_rms"] for row in rows],
        [row["arm_maxdev"] for row in rows],
        motor_label="motor error, ∞-norm, normalised",
    )


def _print(report: Report, outcome: dict[str, Any], path: Path) -> None:
    motors = [f"motor {i}" for i in range(1, 7)]
    rows = outcome["iterations"]
    report.table(
        "Raw: largest motor error [mrad of the motor shaft], tool deviation [µm]",
        ["k", *motors, "arm RMS", "arm max"],
        [
            [
                row["k"],
                *(1e3 * x for x in row["motor_inf"]),
                1e6 * row["arm_rms"],
                1e6 * row["arm_maxdev"],
            ]
            for row in rows
        ],
    )
    report.table(
        "Normalised by the largest at k = 0: thesis (9.5), (9.8), (9.9)",
        ["k", *motors, "arm RMS", "arm max"],
        [
            [
                row["k"],
                *row["motor_inf_normalised"],
                row["arm_rms_normalised"],
                row["arm_maxdev_normalised"],
            ]
            for row in rows
        ],
    )
    report.line(f"Results in {path}")
    report.summary(outcome)
