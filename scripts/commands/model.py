"""`armside model`: a robot's Denavit-Hartenberg table, zero pose, reach and singularities."""

from dataclasses import dataclass
from typing import Any

from armside.kinematics import Robot
from armside.sim.records.summary import summary
from armside.sim.robot_file.find import load_robot

from ..shell.console import Report, run_folder
from ..shell.errors import checking_input
from ..shell.options import Common, options


@options
@dataclass(frozen=True, kw_only=True)
class ModelCfg:
    """The robot, and the form of its description."""

    robot: str = "irb1400"
    """Robot by name (irb1400, irb1400-imu with the links to its IMU, large, ur10, irb120, aubo_i5)
    or a robot file (TOML; URDF: FILE.urdf, FILE.urdf#TIP_LINK; MJCF: FILE.xml, FILE.xml#TIP)."""
    latex: bool = False
    """Print the table and the zero pose as LaTeX."""
    plot: bool = False
    """Draw the link frames in the zero pose (frames.png), as thesis Fig 5.3."""


def model(cfg: ModelCfg = ModelCfg(), *, common: Common = Common()) -> None:
    """Describe a robot: D-H table, T in the zero pose, reach, singular configurations."""
    from armside.kinematics.symbolic.description import as_latex, as_text, describe

    report = Report(common)
    with checking_input():
        robot = describe(load_robot(cfg.robot).arm.robot)
    found = robot.singularities
    values: dict[str, Any] = {
        "table": [[as_text(value) for value in row] for row in robot.table],
        "zero_pose": [[float(x) for x in robot.zero_pose.row(i)] for i in range(4)],
        "reach": robot.reach,
        "singular": {name: str(value) for name, value in vars(found).items()} if found else {},
    }
    if cfg.latex:
        for line in as_latex(robot).splitlines():
            report.line(line)
    else:
        _print(report, robot.robot, values)
    outcome = summary("model", cfg, common, **values)
    if cfg.plot or common.out is not None:
        with run_folder(outcome, common) as folder:
            if cfg.plot:
                from ..figures.frames import draw

                draw(folder / "frames.png", robot.robot)
        report.line(str(folder.path))
    report.summary(outcome)


def _print(report: Report, robot: Robot, values: dict[str, Any]) -> None:
    title = f"{robot.name}, {robot.convention.value} Denavit-Hartenberg, phi: motor angles"
    columns = ("link", "theta [rad]", "d [m]", "a [m]", "alpha [rad]", "joint")
    pairs = enumerate(zip(values["table"], robot.links, strict=True), 1)
    report.table(title, columns, [(str(i), *row, link.joint.value) for i, (row, link) in pairs])
    report.table("Tool at phi = 0", ("x", "y", "z", "p [m]"), values["zero_pose"])
    if values["reach"] is not None:
        low, high = values["reach"]
        report.line(f"Wrist centre {low:.3f} to {high:.3f} m from axis 2, in the plane of the arm")
    for name, expression in values["singular"].items():
        report.line(f"Singular, {name}: {expression} = 0")
