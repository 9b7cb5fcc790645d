"""Link frames of a robot in its zero pose."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from armside.kinematics import Robot
from armside.kinematics.symbolic.description import frame_positions

from .canvas import panels

AXIS = 0.08
"""Drawn length of a frame's axes [m]."""
HALF_WIDTH = 0.4
"""Half of the width of the front view [m]."""
AXIS_COLORS = ("#D55E00", "#009E73", "#0072B2")
"""Colours of the x, y and z axes."""


def draw(file: Path, robot: Robot) -> None:
    """All link frames in the zero pose, x red, y green, z blue, seen from the side and front."""
    origins, axes = frame_positions(robot)
    edges = (0.125, 0.9, 0.11, 0.88)
    with panels(file, (9.0, 5.0), 1, 2, edges=edges, large=True) as views:
        for across, view in enumerate(views):
            _frames(view, origins[:, [across, 2]], axes[:, [across, 2]])
            view.set(xlabel=f"{'xy'[across]} [m]", ylabel="z [m]", aspect="equal")
        views[1].set_xlim(-HALF_WIDTH, HALF_WIDTH)
        figure = views[0].figure
        handles = [Line2D([], [], color=color) for color in AXIS_COLORS]
        figure.legend(handles, ["x axis", "y axis", "z axis"], loc="lower right")
        figure.suptitle(f"Frames of {robot.name} in the zero pose")


def _frames(view: Axes, origins: np.ndarray, axes: np.ndarray) -> None:
    """Origins (m, 2) joined by a line, each with its three axes (m, 2, 3) and its number."""
    view.plot(*origins.T, color="#999999", lw=2)
    numbers: dict[tuple[float, float], list[str]] = {}
    for number, (origin, directions) in enumerate(zip(origins, axes, strict=True)):
        numbers.setdefault((round(origin[0], 4), round(origin[1], 4)), []).append(str(number))
        for color, direction in zip(AXIS_COLORS, directions.T, strict=True):
            view.plot(*zip(origin, origin + AXIS * direction, strict=True), color=color, lw=1.5)
    for place, names in numbers.items():
        text = ", ".join(names)
        view.annotate(text, place, fontsize=8, xytext=(5, 5), textcoords="offset points")
