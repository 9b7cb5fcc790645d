"""`armside imu`: a robot moves with an IMU on its tool; the kinematics predict what it measures."""

from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Group, Parameter

from armside.sim.imu import (
    Compensation,
    ImuExperiment,
    Order,
    ProcessingCfg,
    RestExperiment,
    Scheme,
    notes,
    prepare,
    results,
    run_one,
    run_rest,
)
from armside.sim.instruments.imu import ACCELEROMETER, GYROSCOPE, ImuCfg
from armside.sim.notes import Note
from armside.sim.records.run_folder import RUNS, check_writable
from armside.sim.records.summary import summary
from armside.sim.robot.flexibility import Flexibility
from armside.sim.robot_file.find import check_named

from ..shell.bag_options import BAG_FIELDS, BagCfg
from ..shell.console import Report, run_folder
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import checking_input
from ..shell.options import SOME, Common, FileToRead, Limits, check_limits, options

STANDARD = ProcessingCfg()
_IMU = Parameter(group=Group("Virtual IMU", sort_key=5))
UNIT = ImuCfg()
AT_MOST = {
    "imu_rate": Limits(10.0, 1000.0, "Hz"),
    "accelerometer_noise": Limits(0.0, 1.0, "m/s^2 a root Hz"),
    "gyroscope_noise": Limits(0.0, 10.0, "deg/s a root Hz"),
    "accelerometer_bias": Limits(0.0, 10.0, "m/s^2"),
    "gyroscope_bias": Limits(0.0, 100.0, "deg/s"),
    "mounting_error": Limits(0.0, 10.0, "deg"),
    "clock_offset": Limits(0.0, 100.0, "ms"),
    "clock_drift": Limits(0.0, 1000.0, "ppm"),
    "off": Limits(0.0, 600.0, "s", above=True),
    "on": Limits(0.0, 600.0, "s", above=True),
    "accelerometer_delay": Limits(-1000.0, 1000.0, "ms"),
    "gyroscope_delay": Limits(-1000.0, 1000.0, "ms"),
}
"""At rest, half a minute of the processor or so."""
LARGEST_NUMBER = 20
"""Recordings of one command."""
OF_RECORDED = Limits(0.0, 25.0, "Hz with --recordings", above=True)
"""Cutoff, where motor angles are low-passed before they are differentiated."""
AT_REST = Effort(0.1, 4e6)
"""For each second at rest."""


@options
@dataclass(frozen=True, kw_only=True)
class ImuOptions(BagCfg):
    """Motion of the robot, its IMU, and processing of measurement and prediction.

    Errors of the IMU are one standard deviation, drawn by the seed.
    """

    imu_rate: Annotated[float, _IMU] = UNIT.rate
    """Readings a second [Hz]."""
    accelerometer_noise: Annotated[float, _IMU] = ACCELEROMETER.noise_density
    """Noise density [m/s^2 a root Hz]."""
    gyroscope_noise: Annotated[float, _IMU] = round(float(np.rad2deg(GYROSCOPE.noise_density)), 6)
    """Noise density [deg/s a root Hz]."""
    accelerometer_bias: Annotated[float, _IMU] = ACCELEROMETER.bias
    """Bias at turn-on [m/s^2]."""
    gyroscope_bias: Annotated[float, _IMU] = round(float(np.rad2deg(GYROSCOPE.bias)), 6)
    """Bias at turn-on [deg/s]."""
    mounting_error: Annotated[float, _IMU] = round(float(np.rad2deg(UNIT.mounting_error)), 6)
    """Rotation of the housing about each of its axes [deg]."""
    clock_offset: Annotated[float | None, _IMU] = None
    """Largest offset of its clock [ms; default: 10, at rest 0]."""
    clock_drift: Annotated[float, _IMU] = 1e6 * UNIT.clock_drift
    """Error of its clock's rate [ppm]."""
    robot: str = "irb1400"
    """Robot that moves: irb1400, large, or a robot file (.toml). With --recordings also other names
    (ur10, irb120, aubo_i5, ...)."""
    recordings: Annotated[tuple[Path, ...], SOME] = ()
    """Folders or ROS bags of a real robot's recordings (docs/real.md)."""
    motion: Literal["simultaneous", "sequential", "rest"] = "simultaneous"
    """All motors at once, one at a time, or none: motors off, then on. A robot file that has no
    programs moves about its home."""
    program: FileToRead = None
    """Motion program (TOML) in place of that motion's own."""
    flexibility: Literal["full", "gears", "rigid"] = "full"
    """Elasticity of the robot: gears and structure, gears only, or none."""
    servo: Literal["feedforward", "pid"] = "feedforward"
    """Servo with or without feedforward of the torque of the motion."""
    off: float = 25.0
    """At rest: time with the motors off [s]."""
    on: float = 25.0
    """At rest: time with the motors on [s]."""
    cutoff: float = STANDARD.cutoff
    """Zero-phase low-pass of both sides [Hz]."""
    order: Literal["filter-then-map", "map-then-filter"] = "filter-then-map"
    """Low-pass of joint rates (thesis), or of the prediction."""
    differences: Literal["forward", "central"] = "forward"
    """Difference quotient of motor angles: (5.6), or central."""
    compensation: Literal["actual-orientation", "mean-at-rest"] = "actual-orientation"
    """Gravity and offsets by each sample's orientation, or the mean at rest (thesis)."""
    accelerometer_delay: float = round(1e3 * STANDARD.accelerometer_delay, 3)
    """Delay of its low-pass that is compensated [ms]."""
    gyroscope_delay: float = round(1e3 * STANDARD.gyroscope_delay, 3)
    """Delay of the gyro's low-pass, compensated [ms]."""

    def unit(self, clock_offset: float) -> ImuCfg:
        """The IMU of these options. clock_offset [s]: of the experiment, if none was given."""
        offset = clock_offset if self.clock_offset is None else 1e-3 * self.clock_offset
        accelerometer = replace(
            ACCELEROMETER, noise_density=self.accelerometer_noise, bias=self.accelerometer_bias
        )
        gyroscope = replace(
            GYROSCOPE,
            noise_density=np.deg2rad(self.gyroscope_noise),
            bias=np.deg2rad(self.gyroscope_bias),
        )
        return ImuCfg(
            accelerometer=accelerometer,
            gyroscope=gyroscope,
            rate=self.imu_rate,
            mounting_error=np.deg2rad(self.mounting_error),
            clock_offset=offset,
            clock_drift=1e-6 * self.clock_drift,
        )

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_choice()
        check_limits(self, AT_MOST)
        if self.motion == "rest" and self.program is not None:
            raise ValueError("program and motion rest exclude each other")

    def _check_choice(self) -> None:
        """Raise ValueError for a robot that is not virtual, or options that ask for one."""
        if not self.recordings:
            check_named(self.robot)
            if given := [name for name in sorted(BAG_FIELDS) if getattr(self, name)]:
                raise ValueError(f"{given[0].replace('_', '-')} needs --recordings of a bag")
            return
        if len(self.recordings) > LARGEST_NUMBER:
            raise ValueError(f"give 1 to {LARGEST_NUMBER} recordings, got {len(self.recordings)}")
        ours = {"robot", "recordings", "cutoff", *BAG_FIELDS}
        for field in fields(self):
            if field.name not in ours and getattr(self, field.name) != field.default:
                name = field.name.replace("_", "-")
                raise ValueError(f"--{name} is of the virtual robot, and excludes --recordings")
        OF_RECORDED.check("cutoff", self.cutoff)

    def experiment(self) -> ImuExperiment | RestExperiment:
        """Experiment of these options, in SI. Raises ValueError for what is not allowed."""
        setup: dict[str, Any] = {"robot": self.robot, "flexibility": Flexibility(self.flexibility)}
        setup["torque_feedforward"] = self.servo == "feedforward"
        processing = ProcessingCfg(
            cutoff=self.cutoff,
            order=Order(self.order),
            scheme=Scheme(self.differences),
            compensation=Compensation(self.compensation),
            accelerometer_delay=1e-3 * self.accelerometer_delay,
            gyroscope_delay=1e-3 * self.gyroscope_delay,
        )
        if self.motion == "rest":
            return RestExperiment(**setup, imu=self.unit(0.0), off=self.off, on=self.on)
        setup["imu"] = self.unit(ImuCfg.clock_offset)
        moving = ImuExperiment(**setup, program=self.program, processing=processing)
        return replace(moving, motion=self.motion)


def imu(*, cfg: ImuOptions = ImuOptions(), common: Common = Common()) -> None:
    """Move a robot with an IMU on its tool and predict what the IMU measures.

    Writes summary.json, signals.parquet, imu.parquet, replay.rrd and figures as PNG; of recordings
    of a real robot summary.json and figures.
    """
    from ..figures import imu_results as shown

    if cfg.recordings:
        return _recorded(cfg, common)
    report, said = Report(common), list[Note]()
    with checking_input():
        check_writable(common.out or RUNS / "imu")
        experiment = cfg.experiment()
        if isinstance(experiment, RestExperiment):
            seconds = cfg.off + cfg.on
            refuse_absurd(f"{seconds:g} s at rest", AT_REST * seconds)
        planned = prepare(experiment) if isinstance(experiment, ImuExperiment) else []
    if isinstance(experiment, RestExperiment):
        rest = run_rest(experiment, common.seed)
        outcome = summary("imu", cfg, common, rest=rest.entries)
        leave, show = partial(shown.write_rest, rest), partial(shown.rest_table, rest)
    else:
        done = report.each("moving", lambda one: run_one(experiment, one, common.seed), planned)
        said = notes(done)
        outcome = summary("imu", cfg, common, notes=said, **results(done))
        leave, show = partial(shown.write_runs, done), partial(shown.error_tables, done)
    with run_folder(outcome, common) as folder:
        leave(folder, outcome["config"])
    report.notes(said)
    show(report)
    report.results(outcome, folder.path)


def _recorded(cfg: ImuOptions, common: Common) -> None:
    from armside.sim.imu.chapter5_recorded import process
    from armside.sim.recordings import read_motion
    from armside.sim.robot_file.find import load_robot

    from ..figures import recorded_imu as shown

    report = Report(common)
    with checking_input():
        arm, topics = load_robot(cfg.robot).arm, cfg.topics()
        recordings = [read_motion(one, topics) for one in cfg.recordings]
        done = report.each("aligning", lambda one: process(arm, one, cfg.cutoff), recordings)
    notes = [f"{one.name}: {note}" for one in recordings for note in one.notes]
    outcome = summary("imu", cfg, common, notes=notes, **shown.results(done))
    with run_folder(outcome, common) as folder:
        shown.write(folder, done)
    report.lines(notes)
    shown.tables(report, done)
    report.results(outcome, folder.path)
