"""`armside gears`: transmission error of gears from encoders and a sensor at the tool."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from armside.kinematics import CATALOGUE, Arm
from armside.sim.cell import CELLS
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser.specification import Cut
from armside.sim.records.summary import summary
from armside.sim.robot_file.find import find_cell, load_robot

from ..cutting.options import IndividualCfg, robot_state
from ..shell.bag_options import BAG_FIELDS, BagCfg
from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, Limits, options

if TYPE_CHECKING:
    from armside.sim.gears import GearsCfg
    from armside.sim.recordings import MotionRecording

LARGEST_NUMBER = 20
"""Recordings of one command."""


@options
@dataclass(frozen=True, kw_only=True)
class GearsOptions(IndividualCfg, BagCfg):
    """The robot, the sensor that is learned from, and the bands of frequency."""

    robot: str
    """Robot by name (ur10, irb120, aubo_i5, irb1400, large) or a robot file (TOML, or URDF:
    FILE.urdf, FILE.urdf#TIP_LINK)."""
    measure: Literal["imu", "tracker"] | None = None
    """Learn from [default: the IMU, if there is one]."""
    band: tuple[float, float] | None = None
    """Band that is learned from [Hz] [default: 2.5 16; of a virtual robot 0.6 3.3]."""
    judged: tuple[float, float] | None = None
    """Band in which a tracker judges [Hz] [default: 4 12; of a virtual robot 0.6 3]."""
    largest_order: float | None = None
    """Largest order of the scan [periods per turn of a joint] [default: 420; of a virtual robot
    520]."""
    elastic: bool | None = None
    """Find also how much the arm amplifies errors towards its first resonance [default: with a
    virtual robot]."""
    terms: int = 4
    """Most orders of one joint."""
    pose: str | None = None
    """Pose around which a virtual robot moves [default: the second one]."""
    runs: int | None = None
    """Runs of a virtual robot, 1 to 10 [default: 6]."""

    def __post_init__(self) -> None:
        super().__post_init__()
        Limits(1, 10).check("runs", self.runs)
        self.configuration(virtual=False)

    def configuration(self, *, virtual: bool) -> "GearsCfg":
        """Configuration of the analysis. Raises ValueError for what is not allowed."""
        from armside.sim.gears import VIRTUAL, GearsCfg

        start = VIRTUAL if virtual else GearsCfg()
        names = ("band", "judged", "largest_order", "elastic")
        given = {name: value for name in names if (value := getattr(self, name)) is not None}
        return replace(start, per_joint=self.terms, sensor=self.measure or start.sensor, **given)


def gears(*data: Path, cfg: GearsOptions, common: Common = Common()) -> None:
    """Find the transmission error of an arm's gears, without knowing their ratios.

    data: a folder or a ROS bag for each recording (docs/real.md). Each is judged by what the others
    teach; a single one is judged on its second half. Without any, a virtual robot (large, irb1400,
    a robot file) makes the runs. Writes summary.json, gears.toml, robot.toml with the error, and
    pictures.
    """
    from armside.sim.gears import analyse_gears, coverage_notes

    from ..figures import gears as shown

    report = Report(common)
    with checking_input():
        arm, recordings = _recordings(data, cfg, common.seed, report)
        scans = max(2, len(recordings)) * arm.robot.n_joints
        with report.progress("scanning", total=scans) as step:
            done = analyse_gears(arm, recordings, cfg.configuration(virtual=not data), step)
    notes = [f"{one.name}: {note}" for one in recordings for note in one.notes]
    notes += coverage_notes(done)
    outcome = summary("gears", cfg, common, data=data, notes=notes, **shown.results(done))
    with run_folder(outcome, common) as folder:
        shown.write(folder, done, arm)
    report.lines(notes)
    shown.tables(report, outcome)
    shown.bands_table(report, done)
    report.results(outcome, folder.path)


def _recordings(
    data: Sequence[Path], cfg: GearsOptions, seed: int, report: Report
) -> "tuple[Arm, list[MotionRecording]]":
    from armside.sim.recordings import read_motion

    if len(data) > LARGEST_NUMBER:
        raise ValueError(f"give at most {LARGEST_NUMBER} folders of recordings, got {len(data)}")
    if data:
        own = ("pose", "runs", "individual", "temperature")
        given = [name for name in own if getattr(cfg, name) is not None]
        given += [name for name in ("friction_drift", "without") if getattr(cfg, name)]
        if given:
            said = given[0].replace("_", "-")
            raise ValueError(f"{said} is of a virtual robot: give no recordings with it")
        topics = cfg.topics()
        return load_robot(cfg.robot).arm, [read_motion(one, topics) for one in data]
    if given := [name for name in sorted(BAG_FIELDS) if getattr(cfg, name)]:
        raise ValueError(f"{given[0].replace('_', '-')} is of recordings in bags: none are given")
    from armside.sim.gears.virtual_run import RUNS, recorded

    if cfg.robot in CATALOGUE and cfg.robot not in CELLS:
        runnable = f"{', '.join(CELLS)} and robot files with a model"
        raise ValueError(f"give recordings of {cfg.robot}: only {runnable} can be run")
    cell = find_cell(cfg.robot)
    pose = cfg.pose or [*cell.poses, "p1"][1]
    setup = Cut(robot=cfg.robot, pose=pose, imu=ImuCfg(), **robot_state(cfg))
    runs = range(RUNS if cfg.runs is None else cfg.runs)
    made = report.each("running", lambda run: recorded(setup, seed, run), runs)
    return Arm(cell.robot, cell.limits), made
