"""`armside model`: a robot's Denavit-Hartenberg table, zero pose, reach and singularities."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report
from ..shell.options import Common, options
from .export import ROBOTS, RobotName

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from armside.kinematics.symbolic.description import RobotDescription

AXIS = 0.08
"""Drawn length of a frame's axes [m]."""
HALF_WIDTH = 0.4
"""Of the front view [m]."""
AXIS_COLORS = ("#D55E00", "#009E73", "#0072B2")
"""x, y, z."""


@options
@dataclass(frozen=True, kw_only=True)
class ModelCfg:
    """Which robot, and what to make of it."""

    robot: RobotName = "irb1400"
    """Which robot; irb1400-imu has the two constant links to its IMU."""
    latex: bool = False
    """Print the table and the zero pose as LaTeX."""
    plot: bool = False
    """Draw the link frames in the zero pose (frames.png), as thesis Fig 5.3."""


def model(cfg: ModelCfg = ModelCfg(), *, common: Common = Common()) -> None:
    """Describe a robot: D-H table, T in the zero pose, reach, singular configurations."""
    from armside.kinematics.symbolic.description import as_latex, as_text, describe

    report, found = Report(common), describe(ROBOTS[cfg.robot][0])
    zero = [[float(x) for x in found.zero_pose.row(i)] for i in range(4)]
    table = [[as_text(value) for value in row] for row in found.table]
    singular = _singular(found)
    if cfg.latex:
        for line in as_latex(found).splitlines():
            report.line(line)
    else:
        _print(report, found, table, zero, singular)
    outcome = summary(
        "model", cfg, common, table=table, zero_pose=zero, reach=found.reach, singular=singular
    )
    if cfg.plot or common.out is not None:
        with RunFolder("model", seed=common.seed, out=common.out) as folder:
            (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
            if cfg.plot:
                draw(folder / "frames.png", cfg.robot)
        report.line(str(folder.path))
    report.summary(outcome)


def _singular(found: "RobotDescription") -> dict[str, str]:
    """Name: expression of theta that vanishes there."""
    if found.singularities is None:
        return {}
    names = ("elbow", "shoulder", "wrist")
    return {name: str(getattr(found.singularities, name)) for name in names}


def _print(
    report: Report,
    found: "RobotDescription",
    table: list[list[str]],
    zero: list[list[float]],
    singular: dict[str, str],
) -> None:
    robot = found.robot
    title = f"{robot.name}, {robot.convention.value} Denavit-Hartenberg, phi: motor angles"
    columns = ("link", "theta [rad]", "d [m]", "a [m]", "alpha [rad]", "joint")
    rows = [
        (str(i), *row, link.joint.value)
        for i, (row, link) in enumerate(zip(table, robot.links, strict=True), 1)
    ]
    report.table(title, columns, rows)
    report.table("Tool at phi = 0", ("x", "y", "z", "p [m]"), zero)
    if found.reach is not None:
        low, high = found.reach
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
    """Origins (m, 2) joined by a line, each with three axes (m, 2, 3); numbers where frames are."""
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
