"""`armside model`: a robot's Denavit-Hartenberg table, zero pose, reach and singularities."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from armside.kinematics import Robot
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report
from ..shell.options import Common, options
from .export import ROBOTS, RobotName

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXIS = 0.08
"""Drawn length of a frame's axes [m]."""
HALF_WIDTH = 0.4
"""Half of the width of the front view [m]."""
AXIS_COLORS = ("#D55E00", "#009E73", "#0072B2")
"""Colours of the x, y and z axes."""


@options
@dataclass(frozen=True, kw_only=True)
class ModelCfg:
    """The robot, and the form of its description."""

    robot: RobotName = "irb1400"
    """Robot; irb1400-imu has the two constant links to its IMU."""
    latex: bool = False
    """Print the table and the zero pose as LaTeX."""
    plot: bool = False
    """Draw the link frames in the zero pose (frames.png), as thesis Fig 5.3."""


def model(cfg: ModelCfg = ModelCfg(), *, common: Common = Common()) -> None:
    """Describe a robot: D-H table, T in the zero pose, reach, singular configurations."""
    from armside.kinematics.symbolic.description import as_latex, as_text, describe

    report, robot = Report(common), describe(ROBOTS[cfg.robot][0])
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
        _print(report, robot.robot, **values)
    outcome = summary("model", cfg, common, **values)
    if cfg.plot or common.out is not None:
        with RunFolder("model", seed=common.seed, out=common.out) as folder:
            (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
            if cfg.plot:
                draw(folder / "frames.png", cfg.robot)
        report.line(str(folder.path))
    report.summary(outcome)


def _print(
    report: Report,
    robot: Robot,
    table: list[list[str]],
    zero_pose: list[list[float]],
    reach: tuple[float, float] | None,
    singular: dict[str, str],
) -> None:
    title = f"{robot.name}, {robot.convention.value} Denavit-Hartenberg, phi: motor angles"
    columns = ("link", "theta [rad]", "d [m]", "a [m]", "alpha [rad]", "joint")
    pairs = enumerate(zip(table, robot.links, strict=True), 1)
    report.table(title, columns, [(str(i), *row, link.joint.value) for i, (row, link) in pairs])
    report.table("Tool at phi = 0", ("x", "y", "z", "p [m]"), zero_pose)
    if reach is not None:
        low, high = reach
        report.line(f"Wrist centre {low:.3f} to {high:.3f} m from axis 2, in the plane of the arm")
    for name, expression in singular.items():
        report.line(f"Singular, {name}: {expression} = 0")


def draw(file: Path, robot: RobotName) -> None:
    """All link frames in the zero pose, x red, y green, z blue, seen from the side and front."""
    from matplotlib.lines import Line2D

    from armside.kinematics.symbolic.description import frame_positions

    from ..figures.laser import new_figure, save

    origins, axes = frame_positions(ROBOTS[robot][0])
    figure = new_figure(9.0, 5.0)
    views = figure.subplots(1, 2)
    for view, (across, label) in zip(views, ((0, "x [m]"), (1, "y [m]")), strict=True):
        _frames(view, origins[:, [across, 2]], axes[:, [across, 2]])
        view.set_xlabel(label)
        view.set_ylabel("z [m]")
        view.set_aspect("equal")
    views[1].set_xlim(-HALF_WIDTH, HALF_WIDTH)
    handles = [Line2D([], [], color=color) for color in AXIS_COLORS]
    figure.legend(handles, ["x axis", "y axis", "z axis"], loc="lower right", frameon=False)
    figure.suptitle(f"Frames of {ROBOTS[robot][0].name} in the zero pose")
    save(figure, file)


def _frames(view: "Axes", origins: np.ndarray, axes: np.ndarray) -> None:
    """Origins (m, 2) joined by a line, each with its three axes (m, 2, 3) and its number."""
    view.plot(*origins.T, color="#999999", lw=2)
    numbers: dict[tuple[float, float], list[str]] = {}
    for number, (origin, directions) in enumerate(zip(origins, axes, strict=True)):
        numbers.setdefault((round(origin[0], 4), round(origin[1], 4)), []).append(str(number))
        for color, direction in zip(AXIS_COLORS, directions.T, strict=True):
            view.plot(*zip(origin, origin + AXIS * direction, strict=True), color=color, lw=1.5)
    for place, names in numbers.items():
        view.annotate(
            ", ".join(names), place, fontsize=8, xytext=(5, 5), textcoords="offset points"
        )
