"""`armside measure`: the measures of recorded data, of a run of ours or anybody's."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pyarrow as pa
from cyclopts import Parameter

from armside.sim.cell import CELLS
from armside.sim.evaluation.recorded import Cut, Measured, measure_table
from armside.sim.records.summary import summary
from armside.sim.records.tables import MissingPackageError, read_table
from armside.sim.robot.model import load_model

from ..shell.console import Report, keep
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, options


@options
@dataclass(frozen=True, kw_only=True)
class MeasureCfg:
    """What a file does not say itself. A file of `armside convert` says all of it."""

    robot: Literal["large", "irb1400"] = "large"
    """Whose gear ratios, where --gear is not given."""
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
        if self.radius is not None and not (np.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"radius must be > 0 mm, got {self.radius:g}")
        if not np.linalg.norm(self.normal) > 0.0:
            raise ValueError("normal must not be zero")
        if any(not g > 0.0 for g in self.gear):
            raise ValueError(f"gear ratios must be > 0, got {self.gear}")


def measure(file: Path, *, cfg: MeasureCfg = MeasureCfg(), common: Common = Common()) -> None:
    """Measure recorded data: motor errors, and how round the tool's circle was.

    file: CSV, MATLAB, HDF5 or Parquet with columns time [s], reference_1.., motor_angle_1.. [rad,
    arm side], and if there are any k, tracker_x, tracker_y, tracker_z [m]. See docs/formats.md.
    """
    report = Report(common)
    with checking_input():
        try:
            table = read_table(file)
        except MissingPackageError as error:
            raise InputError(str(error)) from error
        own = (table.schema.metadata or {}).get(b"armside.config")
        rows = _of_a_run(table, file) if own else measure_table(table, gears(cfg), cut(cfg))
    outcome = summary("measure", cfg, common, file=file, iterations=rows)
    keep(outcome, common)
    _print(report, rows)
    report.summary(outcome)


def gears(cfg: MeasureCfg) -> np.ndarray:
    """The ratios given, or those of the robot."""
    if cfg.gear:
        return np.array(cfg.gear)
    return load_model(CELLS[cfg.robot].xml).drives.gear


def cut(cfg: MeasureCfg) -> Cut | None:
    """The circle of the options, in SI units."""
    if cfg.radius is None:
        return None
    return Cut(
        radius=1e-3 * cfg.radius,
        start=-np.inf if cfg.start is None else cfg.start,
        end=np.inf if cfg.end is None else cfg.end,
        normal=cfg.normal,
    )


def _of_a_run(table: pa.Table, file: Path) -> list[Measured]:
    """As `armside laser` measured it, from the signals alone."""
    from armside.sim.evaluation.tool_error import tool_error
    from armside.sim.records.signals import signals_of
    from armside.sim.records.stored_run import StoredRun

    from . import laser

    signals = signals_of(table, source=file.name)
    if signals.config.get("experiment") != "laser":
        raise ValueError(f"{file.name} is of {signals.config.get('experiment')}, not of laser")
    stored = StoredRun(file, {"config": signals.config})
    experiment = laser.prepare(stored.configuration(laser.LaserCfg), signals.seed or 0)
    gear = experiment.loaded.model.drives.gear
    rows = []
    for motors, run in zip(measure_table(table, gear, None), signals.runs, strict=True):
        rms = maxdev = np.nan
        if run.tracker is not None:
            arm = tool_error(experiment.motion, run.tracker.time, run.tracker.position)
            rms, maxdev = arm.rms, arm.maxdev
        rows.append(
            Measured(
                k=motors.k,
                motor_inf=motors.motor_inf,
                motor_two=motors.motor_two,
                arm_rms=rms,
                arm_maxdev=maxdev,
            )
        )
    return rows


def _print(report: Report, rows: list[Measured]) -> None:
    motors = [f"motor {i + 1}" for i in range(len(rows[0].motor_inf))]
    table: list[list[Any]] = [
        [r.k, *(1e3 * float(x) for x in r.motor_inf), 1e6 * r.arm_rms, 1e6 * r.arm_maxdev]
        for r in rows
    ]
    title = "Largest motor error [mrad of the motor shaft], tool deviation [µm]"
    report.table(title, ["k", *motors, "arm RMS", "arm max"], table)
