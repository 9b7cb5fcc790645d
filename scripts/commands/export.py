"""`armside export`: the equations of a robot as code in another language, or as URDF."""

from dataclasses import dataclass
from typing import Literal

from armside import kinematics
from armside.kinematics import Limits, Robot
from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.options import Common, options

ROBOTS: dict[str, tuple[Robot, Limits]] = {
    "irb1400": (kinematics.IRB1400, kinematics.IRB1400_LIMITS),
    "irb1400-imu": (kinematics.IRB1400_IMU, kinematics.IRB1400_LIMITS),
    "large": (kinematics.LARGE_ROBOT, kinematics.LARGE_ROBOT_LIMITS),
}
RobotName = Literal["irb1400", "irb1400-imu", "large"]
Equations = Literal[
    "pose", "jacobian", "jacobian-rate", "acceleration", "measurement", "measurement-jacobian"
]


@options
@dataclass(frozen=True, kw_only=True)
class ExportCfg:
    """The equations of a robot to write, and the language."""

    robot: RobotName = "irb1400"
    """Robot; irb1400-imu has the two constant links to its IMU."""
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
    robot, limits = ROBOTS[cfg.robot]
    if cfg.to == "urdf":
        from armside.kinematics.codegen.urdf import urdf

        return {f"{cfg.robot}.urdf": urdf(robot, limits)}, None
    from armside.kinematics.codegen import Language, write
    from armside.kinematics.equations import forward_kinematics, imu_equations

    home = imu_equations if cfg.what.startswith("measurement") else forward_kinematics
    program = getattr(home, cfg.what.replace("-", "_"))(robot)
    name = f"{cfg.robot}_{program.name}".replace("-", "_")
    return write(program, Language(cfg.to), name), program.operations
