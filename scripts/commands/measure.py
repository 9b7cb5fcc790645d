"""`armside measure`: measures of recorded data, of a stored run or of any other robot."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pyarrow as pa
from cyclopts import Parameter

from armside.sim.cell_file import check_named, find_cell
from armside.sim.evaluation.recorded import CircleTurn, measure_signals, measure_table
from armside.sim.evaluation.recorded_notes import notes_of_signals, notes_of_table
from armside.sim.records.signals import signals_of
from armside.sim.records.summary import summary
from armside.sim.records.tables import read_table
from armside.sim.robot.cell_model import cell_model

from ..cutting.options import LARGEST
from ..shell.console import Report, keep
from ..shell.errors import checking_input
from ..shell.options import Common, options

LARGEST_GEAR = 1e6


@options
@dataclass(frozen=True, kw_only=True)
class MeasureCfg:
    """Gears and circle, for a file without them. A file of `armside convert` holds both."""

    robot: str = "large"
    """Robot with these gear ratios, where --gear is not given: large, irb1400, or a robot file
    (.toml)."""
    gear: Annotated[tuple[float, ...], Parameter(consume_multiple=True)] = ()
    """Gear ratio of each motor; 1 for angles that are of the motor shaft already."""
    radius: float | None = None
    """Radius of the circle that the tracker saw [mm]; without it only motors are measured."""
    start: float | None = None
    """Start of the turn [s] [default: that of the data]."""
    end: float | None = None
    """End of the turn [s] [default: that of the data]."""
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Normal of the circle's plane, in the tracker's axes."""

    def __post_init__(self) -> None:
        check_named(self.robot)
        if self.radius is not None and not (np.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"radius must be > 0 mm, got {self.radius:g}")
        if not 1e-6 < np.linalg.norm(self.normal) < 1e6:
            raise ValueError(f"normal must be a direction, not zero or huge, got {self.normal}")
        if self.radius is not None and self.radius > LARGEST["radius"][0]:
            raise ValueError(f"radius must be at most {LARGEST['radius'][0]:g} mm")
        if self.start is not None and self.end is not None and not self.start < self.end:
            raise ValueError(f"start must be before end, got {self.start:g} and {self.end:g} s")
        if any(not 0.0 < g <= LARGEST_GEAR for g in self.gear):
            raise ValueError(f"gear ratios must be > 0, at most {LARGEST_GEAR:g}, got {self.gear}")


def measure(file: Path, *, cfg: MeasureCfg = MeasureCfg(), common: Common = Common()) -> None:
    """Measure recorded data: motor errors, and how round the tool's circle was.

    file: CSV, MATLAB, HDF5 or Parquet with columns time [s], reference_1.., motor_angle_1.. [rad,
    arm side], and if there are any k, tracker_x, tracker_y, tracker_z [m]. See docs/formats.md.
    """
    report = Report(common)
    with checking_input():
        read = read_table(file)
        if b"armside.config" in (read.schema.metadata or {}):
            signals = signals_of(read, source=file.name)
            rows, said = measure_signals(signals), notes_of_signals(signals)
        else:
            rows, said = measure_table(read, gears(cfg, read), turn(cfg)), notes_of_table(read)
    outcome = summary("measure", cfg, common, file=file, iterations=rows, notes=said)
    keep(outcome, common)
    report.notes(said)
    motors = [f"motor {i + 1}" for i in range(len(rows[0].motor_inf))]
    table: list[list[Any]] = [
        [r.k, *(1e3 * float(x) for x in r.motor_inf), 1e6 * r.arm_rms, 1e6 * r.arm_maxdev]
        for r in rows
    ]
    title = "Largest motor error [mrad of the motor shaft], tool deviation [µm]"
    report.table(title, ["k", *motors, "arm RMS", "arm max"], table, missing=_missing(cfg))
    report.summary(outcome)


def _missing(cfg: MeasureCfg) -> str:
    """Reason for measures that are not there."""
    tool = "the data hold too few samples of a tracker in the turn"
    if cfg.radius is None:
        tool = "the data hold no samples of a tracker, or --radius was not given"
    return f"{tool}; a motor without samples has no error"


def gears(cfg: MeasureCfg, table: pa.Table) -> np.ndarray:
    """Gear ratios given, or those of the robot. Raises ValueError if it has other motors."""
    if cfg.gear:
        return np.array(cfg.gear)
    gear, names = cell_model(find_cell(cfg.robot)).drives.gear, table.column_names
    motors = sum(re.fullmatch(r"reference_\d+", name) is not None for name in names)
    if 0 < motors != len(gear):
        raise ValueError(
            f"the data have {motors} motors and the robot {cfg.robot} has {len(gear)}: give --gear"
        )
    return gear


def turn(cfg: MeasureCfg) -> CircleTurn | None:
    """Circle of the options in SI units, or None without a radius."""
    if cfg.radius is None:
        return None
    start = -np.inf if cfg.start is None else cfg.start
    end = np.inf if cfg.end is None else cfg.end
    return CircleTurn(radius=1e-3 * cfg.radius, start=start, end=end, normal=cfg.normal)
