"""`armside export`: a robot's equations as code, a robot as URDF or MJCF, or what a run learned."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast, get_args

import numpy as np
from cyclopts import Parameter

from armside.ilc.workbench.compare import read_states
from armside.sim.controller import correction_export
from armside.sim.controller.correction_export import RATES, Form
from armside.sim.controller.gate import Beyond, GateError, exceeded, let_through
from armside.sim.controller.limits import GuidanceLimits
from armside.sim.controller.programs import corrected_by, displaced, read_program_file
from armside.sim.controller.stored_correction import StoredCorrection, ended, stored_correction
from armside.sim.records.atomic import write_bytes
from armside.sim.records.files import check_file_to_write
from armside.sim.records.stored_run import read_run
from armside.sim.records.summary import summary
from armside.sim.records.tables import write_table
from armside.sim.robot.kinematics_check import cell_model
from armside.sim.robot_file.find import find_cell, load_robot

from ..cutting.earlier import STATE
from ..shell.console import Report
from ..shell.errors import InputError, checking_input, needs
from ..shell.options import SOME, Common, FileToRead, FileToWrite, Limits, options

if TYPE_CHECKING:
    from armside.arrays import Array
    from armside.sim.cell import Cell

Equations = Literal[
    "pose", "jacobian", "jacobian-rate", "acceleration", "measurement", "measurement-jacobian"
]
OfRobot = Literal["c", "matlab", "fortran", "python", "latex", "urdf", "mjcf"]
OfRun = Literal["csv", "mat", "parquet", "rsi", "egm"]
FORM_OF = {"rsi": "joint-correction", "egm": "joint-path"}
"""What each protocol's messages hold."""
CYCLE = 250.0
"""[Hz], of both protocols."""
_RUN = "Folder of a run of laser, cut or learn, whose correction is written."


@options
@dataclass(frozen=True, kw_only=True)
class ExportCfg:
    """What is written of a robot, or of a run."""

    robot: str | None = None
    """Robot by name or a robot file [default: irb1400; of a run: its own]. irb1400, irb1400-imu
    with the links to its IMU, large, ur10, irb120, aubo_i5; TOML; URDF: FILE.urdf,
    FILE.urdf#TIP_LINK; MJCF: FILE.xml, FILE.xml#TIP. Of a run: its kinematics make the tool
    path."""
    what: Literal[Equations, Form] | None = None
    """Equations of a robot [default: jacobian], or what is written of a run [default:
    joint-correction]. Equations are functions of the motor angles, and not used for urdf and mjcf.
    joint-correction: u of each axis; joint-path: r + u, the motor angles to be commanded;
    tool-path: pose of the tool at r + u, by the nominal kinematics."""
    to: Literal[OfRobot, OfRun] | None = None
    """Language [default: c], or kind of file of a run [default: csv]. urdf (for ROS) and mjcf (for
    MuJoCo) are the robot itself, with its masses. rsi: messages with axis corrections [deg], egm:
    messages with joint angles [deg], both at 250 Hz."""
    rate: float | None = None
    """Of a run: samples a second [Hz; default: its own]. Its samples are then unchanged."""
    file: FileToWrite = None
    """Of a run: file to write [default: WHAT.TO here]."""
    law: str | None = None
    """Of a run of learn with several laws: the law."""
    beyond: Annotated[tuple[Beyond, ...], SOME] = ()
    """Of a run: what is written although the gate before a robot would hold it back; the file says
    so (docs/controllers.md)."""
    into: FileToRead = None
    """Of a run of laser or cut: a robot's program (.mod, .src with its .dat, .script) that follows
    its path. Its linear moves get other numbers, every other byte stays; it is written to --file,
    or beside it as NAME-corrected. The program itself is never written over. See
    docs/programs.md."""

    def __post_init__(self) -> None:
        Limits(*RATES, "Hz").check("rate", self.rate)

    def of_robot(self) -> "ExportCfg":
        """With the defaults for a robot. Raises ValueError for options of a run."""
        for name in ("rate", "file", "law", "beyond", "into"):
            if getattr(self, name) not in (None, ()):
                raise ValueError(f"--{name} is of a run: give its folder")
        made = replace(
            self, robot=self.robot or "irb1400", what=self.what or "jacobian", to=self.to or "c"
        )
        made._check(get_args(Equations), get_args(OfRobot), "a robot", "give the folder of a run")
        return made

    def of_run(self) -> "ExportCfg":
        """With the defaults for a run. Raises ValueError for options of a robot, or that misfit."""
        made = replace(self, what=self.what or "joint-correction", to=self.to or "csv")
        made._check(get_args(Form), get_args(OfRun), "a run", "leave the run out")
        if (form := FORM_OF.get(str(made.to), made.what)) != made.what:
            raise ValueError(f"{made.to} messages hold a {form}: give --what {form}")
        if made.to in FORM_OF and made.rate not in (None, CYCLE):
            raise ValueError(f"{made.to} has {CYCLE:g} Hz, got {made.rate:g}")
        return made

    def _check(self, what: tuple[str, ...], to: tuple[str, ...], of: str, advice: str) -> None:
        for name, given, allowed in (("what", self.what, what), ("to", self.to, to)):
            if given not in allowed:
                text = f"--{name} of {of} is {', '.join(allowed)}, got {given}"
                raise ValueError(f"{text}: {advice} for that")


def export(
    run: Annotated[Path | None, Parameter(help=_RUN)] = None,
    /,
    *,
    cfg: ExportCfg = ExportCfg(),
    common: Common = Common(),
) -> None:
    """Write a robot's equations as code, a robot as URDF or MJCF, or the correction of a run.

    Without a run: C99, MATLAB, Fortran, Python or LaTeX, whose header states robot, convention,
    units and the order of arguments; files go to --out, or to a new folder under runs/. With one:
    the correction that it ended with, for a controller or a program, and nothing else. See
    docs/formats.md for columns and resampling.
    """
    report = Report(common)
    if run is None:
        _export_robot(report, cfg, common)
    elif cfg.into is not None:
        _export_program(report, run, cfg.into, cfg, common)
    else:
        _export_correction(report, run, cfg, common)


def _export_robot(report: Report, cfg: ExportCfg, common: Common) -> None:
    with checking_input():
        cfg = cfg.of_robot()
        files, operations = _files(cfg)
    report.texts(
        files,
        summary("export", cfg, common, files=sorted(files), operations=operations),
        *([] if operations is None else [f"{operations} operations after sharing"]),
    )


def _files(cfg: ExportCfg) -> tuple[dict[str, str], int | None]:
    named, what = str(cfg.robot), str(cfg.what)
    word = Path(named.partition("#")[0]).stem
    if cfg.to in ("urdf", "mjcf"):
        from armside.kinematics.codegen.robot_xml import mjcf, urdf

        arm, bodies, notes = load_robot(named, masses=True)
        write, ending = (urdf, "urdf") if cfg.to == "urdf" else (mjcf, "xml")
        return {f"{word}.{ending}": write(*arm, bodies, notes)}, None
    from armside.kinematics.codegen import Language, write
    from armside.kinematics.equations import forward_kinematics, imu_equations

    robot = load_robot(named).arm.robot
    home = imu_equations if what.startswith("measurement") else forward_kinematics
    program = getattr(home, what.replace("-", "_"))(robot)
    name = re.sub(r"\W|^(?=\d)", "_", f"{word}_{program.name}", flags=re.ASCII)
    return write(program, Language(cfg.to), name), program.operations


def _export_correction(report: Report, run: Path, cfg: ExportCfg, common: Common) -> None:
    with checking_input():
        cfg = cfg.of_run()
        file = cfg.file or Path(f"{cfg.what}.{cfg.to}")
        if file.suffix.lower() != f".{cfg.to}":
            raise InputError(f"{cfg.to} files end with .{cfg.to}: {file.name}")
        check_file_to_write(file)
        stored = stored_correction(read_run(run), cfg.law)
        rate = cfg.rate or (CYCLE if cfg.to in FORM_OF else 1.0 / stored.sample_time)
        cell = _cell(cfg, stored)
        beyond, notes = _let_through(run, cfg, stored, cell)
        joints = correction_export.joint_values(stored, cast(Form, cfg.what), rate)
        names = _write(file, cfg, stored, joints, rate, cell, beyond)
    found = {"run": run, "written": file, "largest": float(np.abs(stored.correction).max())}
    found |= {"k": stored.k, "law": stored.law, "rate": rate, "samples": len(joints)}
    found["notes"] = notes = [*beyond, *notes]
    line = f"{file}: {len(joints)} samples of {names} at {rate:g} Hz, k = {stored.k}"
    outcome = summary("export", cfg, common, **found)
    report.keep(outcome)
    report.notes(notes)
    report.line(line)
    report.summary(outcome)


def _export_program(report: Report, run: Path, into: Path, cfg: ExportCfg, common: Common) -> None:
    with checking_input():
        for name in ("what", "to", "rate"):
            if getattr(cfg, name) is not None:
                raise InputError(f"--{name} is not for --into, which writes the same language")
        file = cfg.file or into.with_name(f"{into.stem}-corrected{into.suffix}")
        program, stored = read_program_file(into), read_run(run)
        files = [file, *(file.with_suffix(Path(t.name).suffix) for t in program.texts[1:])]
        for each, text in zip(files, program.texts, strict=True):
            if each.suffix != Path(text.name).suffix:
                raise InputError(f"--file must end with {Path(text.name).suffix}: {each.name}")
            if each.exists() and each.samefile(into.with_name(text.name)):
                raise InputError(f"{each} is the program itself: give another --file")
            if cfg.file is None and each.exists():
                raise InputError(f"{each} exists: give a --file, which may be one to write over")
            check_file_to_write(each)
        beyond, notes = list[str](), list[str]()
        speed = 1e-3 * stored.summary["config"].get("speed", 0.0)
        if stored.summary["config"].get("as_program"):
            for name in ("law", "robot"):
                if getattr(cfg, name) is not None:
                    of = f"a run of a program, whose targets have no {name}"
                    raise InputError(f"--{name} is not for {of}: leave it out")
            (state,) = read_states(stored.file(STATE)).values()
            if state is None:
                raise InputError(f"{run} stored no targets to take over")
            beyond = _named(run, ended(stored.summary, state.loop.k), cfg)
            made = displaced(program, stored.path, state.loop.correction, speed)
        else:
            correction = stored_correction(stored, cfg.law)
            cell = _cell(cfg, correction)
            if cell is None:
                raise InputError("a program needs a robot, and the run names none: give --robot")
            beyond, notes = _let_through(run, cfg, correction, cell)
            drives = cell_model(cell).drives
            made = corrected_by(program, stored.path, correction, cell, drives, speed)
    for each, text in zip(files, made.texts, strict=True):
        write_bytes(each, text.content.encode("latin-1"))
    found = {key: value for key, value in vars(made).items() if key != "texts"}
    found["notes"] = notes = [*beyond, *notes]
    outcome = summary("export", cfg, common, run=run, written=file, **found)
    report.keep(outcome)
    report.notes(notes)
    report.lines([f"{file}: {made.changed} of {made.targets} targets changed", made.line])
    report.summary(outcome)


def _cell(cfg: ExportCfg, stored: StoredCorrection) -> "Cell | None":
    """Robot of the correction; one that is missing matters to the path of its tool alone."""
    robot = cfg.robot or stored.robot
    if robot is None:
        return None
    try:
        return find_cell(robot)
    except (OSError, ValueError):
        if cfg.what == "tool-path" or cfg.robot is not None:
            raise
        return None


def _let_through(
    run: Path, cfg: ExportCfg, stored: StoredCorrection, cell: "Cell | None"
) -> tuple[list[str], list[str]]:
    """What the gate lets through by its name, and notes on what it could not check. Raises
    InputError for what it holds back."""
    found, unchecked = dict(stored.ended), list[str]()
    if stored.unit != "rad" and cfg.robot is None:
        unchecked.append("of an own plant: neither the correction nor a range is checked")
    else:
        limits = None if cell is None else GuidanceLimits.of_cell(cell)
        slides, path = () if cell is None else cell.robot.slides, stored.reference
        found |= exceeded(
            stored.correction, stored.sample_time, path=path, limits=limits, slides=slides
        )
        if cell is None:
            unchecked.append("no robot is known: ranges and speeds of its joints are not checked")
    return _named(run, found, cfg), unchecked


def _named(run: Path, found: Mapping[str, str], cfg: ExportCfg) -> list[str]:
    """Lines on what is let through by its name. Raises InputError for what is held back."""
    try:
        return let_through(found, cfg.beyond)
    except GateError as error:
        raise InputError(f"{run}: {error}") from error


def _write(
    file: Path,
    cfg: ExportCfg,
    stored: StoredCorrection,
    joints: "Array",
    rate: float,
    cell: "Cell | None",
    beyond: Sequence[str],
) -> str:
    """Write the file. Words for what it holds."""
    to, form = str(cfg.to), cast(Form, cfg.what)
    unit = stored.unit if cfg.robot is None else "rad"
    units = correction_export.units_of(cell, joints.shape[1], unit)
    if to in FORM_OF:
        if set(units) != {"rad"}:
            raise InputError(f"{to} messages hold angles, these axes have {', '.join(units)}")
        if to == "rsi":
            content = correction_export.rsi_lines(joints, beyond)
        else:
            with needs("controllers", "EGM", "protobuf"):
                content = correction_export.egm_messages(joints)
        write_bytes(file, content)
        return f"{joints.shape[1]} axes [deg]"
    if form != "tool-path":
        found = correction_export.joint_columns(joints, form, units)
    elif cell is None:
        raise InputError("a tool path needs a robot, and the run names none: give --robot")
    else:
        found = correction_export.tool_columns(joints, cell)
    about: dict[str, Any] = {"form": form, "rate": rate, "k": stored.k, "law": stored.law}
    about |= {"beyond": beyond} if beyond else {}
    notes = {key: json.dumps(value) for key, value in about.items()}
    write_table(file, correction_export.table(found, rate, notes))
    return f"{len(found)} columns"
