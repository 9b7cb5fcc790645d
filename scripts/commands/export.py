"""`armside export`: the equations of a robot as code in another language, or as URDF."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from armside.kinematics import Arm
from armside.sim.cell_file import find_robot
from armside.sim.records.summary import summary

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
    or a robot file (TOML, or URDF: FILE.urdf, FILE.urdf#TIP_LINK)."""
    what: Equations = "jacobian"
    """Function of the motor angles; not used for urdf."""
    to: Literal["c", "matlab", "fortran", "python", "latex", "urdf"] = "c"
    """Language; urdf is the robot itself, for ROS."""


def export(cfg: ExportCfg = ExportCfg(), *, common: Common = Common()) -> None:
    """Write a robot's equations as C99, MATLAB, Fortran, Python or LaTeX, or the robot as URDF.

    Files go to `--out`, or to a new folder under runs/. Their header comment states robot,
    convention, units and the order of arguments.
    """
    report = Report(common)
    with checking_input():
        arm = find_robot(cfg.robot)
    files, operations = _files(cfg, arm)
    outcome = summary("export", cfg, common, files=sorted(files), operations=operations)
    with run_folder(outcome, common) as folder:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    for name in files:
        report.line(str(folder.path / name))
    if operations is not None:
        report.line(f"{operations} operations after sharing")
    report.summary(outcome)


def _files(cfg: ExportCfg, arm: Arm) -> tuple[dict[str, str], int | None]:
    """Name and text of each file, and the number of operations of the code."""
    word = Path(cfg.robot).stem
    if cfg.to == "urdf":
        from armside.kinematics.codegen.urdf import urdf

        return {f"{word}.urdf": urdf(*arm)}, None
    from armside.kinematics.codegen import Language, write
    from armside.kinematics.equations import forward_kinematics, imu_equations

    home = imu_equations if cfg.what.startswith("measurement") else forward_kinematics
    program = getattr(home, cfg.what.replace("-", "_"))(arm.robot)
    name = re.sub(r"\W|^(?=\d)", "_", f"{word}_{program.name}", flags=re.ASCII)
    return write(program, Language(cfg.to), name), program.operations
