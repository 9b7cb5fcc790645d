"""`armside gears`: transmission error of gears from encoders and a sensor at the tool."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from armside.sim.cell_file import find_robot
from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, options

LARGEST_NUMBER = 20
"""Recordings of one command."""


@options
@dataclass(frozen=True, kw_only=True)
class GearsOptions:
    """The robot, the sensor that is learned from, and the bands of frequency."""

    robot: str
    """Robot by name (ur10, irb120, aubo_i5, irb1400, large) or a robot file (TOML, or URDF:
    FILE.urdf, FILE.urdf#TIP_LINK)."""
    sensor: Literal["imu", "tracker"] | None = None
    """Sensor to learn from [default: the IMU where there is one]."""
    band: tuple[float, float] = (2.5, 16.0)
    """Band that is learned from [Hz]."""
    judged: tuple[float, float] = (4.0, 12.0)
    """Band in which a tracker judges [Hz]."""
    largest_order: float = 420.0
    """Largest order of the scan [periods per turn of a joint]."""
    terms: int = 4
    """Most orders of one joint."""

    def __post_init__(self) -> None:
        self.configuration()

    def configuration(self) -> Any:
        """Configuration of the analysis. Raises ValueError for what is not allowed."""
        from armside.sim.gears import GearsCfg

        return GearsCfg(
            sensor=self.sensor,
            band=self.band,
            judged=self.judged,
            largest_order=self.largest_order,
            per_joint=self.terms,
        )


def gears(*data: Path, cfg: GearsOptions, common: Common = Common()) -> None:
    """Find the transmission error of an arm's gears, without knowing their ratios.

    data: one folder for each recording (docs/real.md). Each is judged by what the others teach; a
    single one is judged on its second half. Writes summary.json, robot.toml with the error, and
    pictures.
    """
    from armside.sim.gears import analyse
    from armside.sim.measured import read_motion

    from ..figures import gears as shown

    report = Report(common)
    with checking_input():
        if not 1 <= len(data) <= LARGEST_NUMBER:
            raise ValueError(f"give 1 to {LARGEST_NUMBER} folders of recordings, got {len(data)}")
        arm, recordings = find_robot(cfg.robot), [read_motion(folder) for folder in data]
        scans = max(2, len(recordings)) * arm.robot.n_joints
        with report.progress("scanning", total=scans) as step:
            done = analyse(arm, recordings, cfg.configuration(), step)
    notes = [f"{one.name}: {note}" for one in recordings for note in one.notes]
    found: dict[str, Any] = shown.results(done)
    outcome = summary("gears", cfg, common, data=list(data), notes=notes, **found)
    with run_folder(outcome, common) as folder:
        shown.write(folder, done, arm)
    for note in notes:
        report.line(note)
    shown.tables(report, outcome)
    shown.bands_table(report, done)
    report.results(outcome, folder.path)
