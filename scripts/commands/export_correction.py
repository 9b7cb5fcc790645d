"""`armside export-correction`: the learned correction of a run, for a controller or a program."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from armside.sim.controller.correction_export import (
    RATES,
    Form,
    joint_columns,
    joint_values,
    table,
    tool_columns,
    units_of,
)
from armside.sim.controller.stored_correction import StoredCorrection, stored_correction
from armside.sim.records.atomic import write_bytes
from armside.sim.records.files import check_file_to_write
from armside.sim.records.stored_run import read_run
from armside.sim.records.summary import summary
from armside.sim.records.tables import write_table

from ..shell.console import Report, keep
from ..shell.errors import InputError, checking_input, needs
from ..shell.options import Common, FileToWrite, options

if TYPE_CHECKING:
    from armside.arrays import Array
    from armside.sim.cell import Cell

FORM_OF = {"rsi": "joint-correction", "egm": "joint-path"}
"""What each protocol's messages hold."""
CYCLE = 250.0
"""[Hz], of both protocols."""


@options
@dataclass(frozen=True, kw_only=True)
class ExportCorrectionCfg:
    """What is written, at which rate, and the kind of file."""

    form: Annotated[Form, Parameter(name="--as")] = "joint-correction"
    """joint-correction: u of each axis; joint-path: r + u, the motor angles to be commanded;
    tool-path: pose of the tool at r + u, by the nominal kinematics."""
    rate: float | None = None
    """Samples a second [Hz; default: that of the run, whose samples are then unchanged]."""
    to: Literal["csv", "mat", "parquet", "rsi", "egm"] = "csv"
    """Kind of file; rsi: messages with axis corrections [deg], egm: messages with joint angles
    [deg], both at 250 Hz."""
    file: FileToWrite = None
    """File to write [default: FORM.KIND in the working folder]."""
    law: str | None = None
    """Law whose correction is wanted, where `learn` compared several."""
    robot: str | None = None
    """Robot whose kinematics make the tool path [default: that of the run]."""

    def __post_init__(self) -> None:
        if self.rate is not None and not RATES[0] <= self.rate <= RATES[1]:
            raise ValueError(f"rate must be {RATES[0]:g} to {RATES[1]:g} Hz, got {self.rate:g}")
        if (form := FORM_OF.get(self.to, self.form)) != self.form:
            raise ValueError(f"{self.to} messages hold a {form}: give --as {form}")
        if self.to in FORM_OF and self.rate not in (None, CYCLE):
            raise ValueError(f"{self.to} has {CYCLE:g} Hz, got {self.rate:g}")


def export_correction(
    run: Path, *, cfg: ExportCorrectionCfg = ExportCorrectionCfg(), common: Common = Common()
) -> None:
    """Write the correction that a run ended with, and nothing else, for a controller or a program.

    run: folder of a run of laser, cut or learn. See docs/formats.md for columns and resampling.
    """
    report = Report(common)
    with checking_input():
        file = cfg.file or Path(f"{cfg.form}.{cfg.to}")
        if file.suffix.lower() != f".{cfg.to}":
            raise InputError(f"{cfg.to} files end with .{cfg.to}: {file.name}")
        check_file_to_write(file)
        stored = stored_correction(read_run(run), cfg.law)
        rate = cfg.rate or (CYCLE if cfg.to in FORM_OF else 1.0 / stored.sample_time)
        joints = joint_values(stored, cfg.form, rate)
        cell = _cell(cfg, stored)
        names = _write(file, cfg, stored, joints, rate, cell)
    largest = float(np.abs(stored.correction).max())
    about = {"k": stored.k, "law": stored.law, "rate": rate, "samples": len(joints)}
    outcome = summary(
        "export-correction", cfg, common, run=run, written=file, largest=largest, **about
    )
    keep(outcome, common)
    report.line(f"{file}: {len(joints)} samples of {names} at {rate:g} Hz, k = {stored.k}")
    report.summary(outcome)


def _cell(cfg: ExportCorrectionCfg, stored: StoredCorrection) -> "Cell | None":
    """Robot of the correction; one that is missing matters to the path of its tool alone."""
    from armside.sim.robot_file.find import find_cell

    robot = cfg.robot or stored.robot
    if robot is None:
        return None
    try:
        return find_cell(robot)
    except (OSError, ValueError):
        if cfg.form == "tool-path" or cfg.robot is not None:
            raise
        return None


def _write(
    file: Path,
    cfg: ExportCorrectionCfg,
    stored: StoredCorrection,
    joints: "Array",
    rate: float,
    cell: "Cell | None",
) -> str:
    """Write the file. Words for what it holds."""
    units = units_of(cell, joints.shape[1], stored.unit if cfg.robot is None else "rad")
    if cfg.to in FORM_OF:
        if set(units) != {"rad"}:
            raise InputError(f"{cfg.to} messages hold angles, these axes have {', '.join(units)}")
        write_bytes(file, _messages(cfg.to, joints))
        return f"{joints.shape[1]} axes [deg]"
    if cfg.form != "tool-path":
        found = joint_columns(joints, cfg.form, units)
    elif cell is None:
        raise InputError("a tool path needs a robot, and the run names none: give --robot")
    else:
        found = tool_columns(joints, cell)
    about: dict[str, Any] = {"form": cfg.form, "rate": rate, "k": stored.k, "law": stored.law}
    write_table(file, table(found, rate, {key: json.dumps(value) for key, value in about.items()}))
    return f"{len(found)} columns"


def _messages(protocol: str, joints: "Array") -> bytes:
    from armside.sim.controller import correction_export as streams

    if protocol == "rsi":
        return streams.rsi_lines(joints)
    with needs("controllers", "EGM", "protobuf"):
        return streams.egm_messages(joints)
