"""`armside export`: equations of a robot as code in another language, or itself as URDF or MJCF."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from armside.sim.records.summary import summary
from armside.sim.robot_file.find import load_robot

from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, options

Equations = Literal[
    "pose", "jacobian", "jacobian-rate", "acceleration", "measurement", "measurement-jacobian"
]


@options
@dataclass(frozen=True, kw_only=True)
class ExportCfg:
    """The equations of a robot to write, and the language."""

    robot: str = "irb1400"
    """Robot by name (irb1400, irb1400-imu with the links to its IMU, large, ur10, irb120, aubo_i5)
    or a robot file (TOML; URDF: FILE.urdf, FILE.urdf#TIP_LINK; MJCF: FILE.xml, FILE.xml#TIP)."""
    what: Equations = "jacobian"
    """Function of the motor angles; not used for urdf and mjcf."""
    to: Literal["c", "matlab", "fortran", "python", "latex", "urdf", "mjcf"] = "c"
    """Language; urdf (for ROS) and mjcf (for MuJoCo) are the robot itself, with its masses."""


def export(cfg: ExportCfg = ExportCfg(), *, common: Common = Common()) -> None:
    """Write a robot's equations as C99, MATLAB, Fortran, Python, LaTeX, or the robot as URDF, MJCF.

    Files go to `--out`, or to a new folder under runs/. Their header comment states robot,
    convention, units and the order of arguments.
    """
    report = Report(common)
    with checking_input():
        files, operations = _files(cfg)
    outcome = summary("export", cfg, common, files=sorted(files), operations=operations)
    with run_folder(outcome, common) as folder:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    for name in files:
        report.line(str(folder.path / name))
    if operations is not None:
        report.line(f"{operations} operations after sharing")
    report.summary(outcome)


def _files(cfg: ExportCfg) -> tuple[dict[str, str], int | None]:
    """Name and text of each file, and the number of operations of the code."""
    if cfg.to in ("urdf", "mjcf"):
        return _robot(cfg), None
    from armside.kinematics.codegen import Language, write
    from armside.kinematics.equations import forward_kinematics, imu_equations

    robot = load_robot(cfg.robot).arm.robot
    home = imu_equations if cfg.what.startswith("measurement") else forward_kinematics
    program = getattr(home, cfg.what.replace("-", "_"))(robot)
    name = re.sub(r"\W|^(?=\d)", "_", f"{_word(cfg)}_{program.name}", flags=re.ASCII)
    return write(program, Language(cfg.to), name), program.operations


def _robot(cfg: ExportCfg) -> dict[str, str]:
    """The robot itself, with the masses that its source has."""
    from armside.kinematics.codegen.robot_xml import mjcf, urdf

    arm, bodies, notes = load_robot(cfg.robot, masses=True)
    write, ending = (urdf, "urdf") if cfg.to == "urdf" else (mjcf, "xml")
    return {f"{_word(cfg)}.{ending}": write(*arm, bodies, notes)}


def _word(cfg: ExportCfg) -> str:
    """First part of the names of files."""
    return Path(cfg.robot.partition("#")[0]).stem
