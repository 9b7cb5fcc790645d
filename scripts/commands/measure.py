"""`armside measure`: measures of recorded data, of a stored run or of any other robot."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow as pa

from armside.kinematics import Limits as JointLimits
from armside.sim.evaluation.recorded import (
    CircleTurn,
    ContourTurn,
    IterationMeasures,
    measure_signals,
    measure_table,
    notes_of_signals,
    notes_of_table,
)
from armside.sim.part.contour_file import read_contour
from armside.sim.records.files import reading
from armside.sim.records.signals import signals_of
from armside.sim.records.stored_run import read_run
from armside.sim.records.summary import summary
from armside.sim.records.tables import read_table
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot_file.find import check_named, find_cell

from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import SOME, Common, FileToRead, Limits, check_limits, options

LIMITS = {
    "radius": Limits(0.0, 5e3, "mm", above=True),
    "turned": Limits(-360.0, 360.0, "degrees"),
    "gear": Limits(0.0, 1e6, above=True),
}
MOTORS, TOOL = "largest motor error [mrad of the motor shaft]", "tool deviation [µm]"
NO_TOOL = "It needs a tracker's samples in the turn, and --radius or --contour for own data"


@options
@dataclass(frozen=True, kw_only=True)
class MeasureCfg:
    """Gears and circle, for a file without them. A file of `armside convert` holds both."""

    robot: str = "large"
    """Robot with these gear ratios, where --gear is not given: large, irb1400, or a robot file
    (.toml)."""
    gear: Annotated[tuple[float, ...], SOME] = ()
    """Gear ratio of each motor; 1 for angles that are of the motor shaft already."""
    radius: float | None = None
    """Radius of the circle that the tracker saw [mm]. Without it and a contour only motors are
    measured."""
    contour: FileToRead = None
    """File (TOML or DXF) with the contour that the tracker saw, in place of a circle."""
    turned: float = 0.0
    """Rotation of that contour in its plane [deg]; right to 20 degrees, the rest is fitted."""
    start: float | None = None
    """Start of the turn [s] [default: that of the data]."""
    end: float | None = None
    """End of the turn [s] [default: that of the data]."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Normal of the plane of circle or contour, in the tracker's axes."""

    def __post_init__(self) -> None:
        check_named(self.robot)
        check_limits(self, LIMITS)
        if not 1e-6 < np.linalg.norm(self.normal) < 1e6:
            raise ValueError(f"normal must be a direction, not zero or huge, got {self.normal}")
        if self.radius is not None and self.contour is not None:
            raise ValueError("give a radius or a contour, not both")
        if self.start is not None and self.end is not None and not self.start < self.end:
            raise ValueError(f"start must be before end, got {self.start:g} and {self.end:g} s")


def measure(file: Path, /, *, cfg: MeasureCfg = MeasureCfg(), common: Common = Common()) -> None:
    """Measure recorded data: motor errors, and how far the tool was from its circle or contour.

    file: folder of a run; or CSV, MATLAB, HDF5 or Parquet with columns time [s], reference_1..,
    motor_angle_1.. [rad, arm side], and if there are any k, tracker_x, tracker_y, tracker_z [m].
    See docs/formats.md.
    """
    report = Report(common)
    with checking_input():
        file = read_run(file).file("signals.parquet") if file.is_dir() else file
        read = read_table(file)
        if b"armside.config" in (read.schema.metadata or {}):
            with reading(file):
                signals = signals_of(read, source=file.name)
                rows = measure_signals(signals, limits_of(signals.config.get("robot")))
                said = notes_of_signals(signals)
        else:
            ratios, curve = gears(cfg, read), turn(cfg)
            limits = limits_of(None if cfg.gear or not len(ratios) else cfg.robot)
            with reading(file):
                rows = measure_table(read, ratios, curve, limits)
                said = notes_of_table(read)
    outcome = summary("measure", cfg, common, file=file, iterations=rows, notes=said)
    report.keep(outcome)
    report.notes(said)
    show(report, rows)
    report.summary(outcome)


def show(report: Report, rows: Sequence[IterationMeasures]) -> None:
    """Table of the measures that are there; what no iteration has is left out and named."""
    motors = [f"motor {i + 1}" for i in range(len(rows[0].motor_inf))]
    of_motors = 1e3 * np.array([row.motor_inf for row in rows], dtype=float)
    of_tool = 1e6 * np.array([(row.arm_rms, row.arm_maxdev) for row in rows])
    columns = dict(zip([*motors, "arm RMS", "arm max"], [*of_motors.T, *of_tool.T], strict=True))
    there = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    titles = (("motor", MOTORS), ("arm", TOOL))
    title = ", ".join(text for kind, text in titles if any(n.startswith(kind) for n in there))
    table: list[list[Any]] = [
        [row.k, *(float(values[i]) for values in there.values())] for i, row in enumerate(rows)
    ]
    if there:
        some = "too few samples in that run"
        report.table(title[0].upper() + title[1:], ["k", *there], table, missing=some)
    if absent := [name for name in motors if name not in there]:
        report.line(f"Not measured: {', '.join(absent)}, without samples")
    if "arm RMS" not in there:
        report.line(f"Not measured: the tool. {NO_TOOL}")


def limits_of(robot: Any) -> JointLimits | None:
    """Joint limits of a robot by name or file; None where it is not known, or not there."""
    try:
        return find_cell(robot).limits if isinstance(robot, str) else None
    except (ValueError, OSError):
        return None


def gears(cfg: MeasureCfg, table: pa.Table) -> np.ndarray:
    """Gear ratios given, or those of the robot; none for data of a tracker alone. Raises ValueError
    if the robot has other motors."""
    if cfg.gear:
        return np.array(cfg.gear)
    names = table.column_names
    motors = sum(re.fullmatch(r"reference_\d+", name) is not None for name in names)
    if not motors and (cfg.radius is not None or cfg.contour is not None):
        return np.empty(0)
    gear = cell_model(find_cell(cfg.robot)).drives.gear
    if 0 < motors != len(gear):
        raise ValueError(
            f"the data have {motors} motors and the robot {cfg.robot} has {len(gear)}: give --gear"
        )
    return gear


def turn(cfg: MeasureCfg) -> CircleTurn | ContourTurn | None:
    """Circle or contour of the options in SI units; None without either."""
    start = -np.inf if cfg.start is None else cfg.start
    end = np.inf if cfg.end is None else cfg.end
    if cfg.contour is not None:
        curve, turned = read_contour(cfg.contour), float(np.deg2rad(cfg.turned))
        return ContourTurn(contour=curve, start=start, end=end, normal=cfg.normal, turned=turned)
    if cfg.radius is None:
        return None
    return CircleTurn(radius=1e-3 * cfg.radius, start=start, end=end, normal=cfg.normal)
