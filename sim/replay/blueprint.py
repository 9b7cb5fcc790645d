"""Layout of a replay: its first view shows that the motors learn and the tool need not."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from armside.arrays import Array

LEGEND = rrb.PlotLegend(corner=rrb.Corner2D.RightTop)
NO_LEGEND = rrb.PlotLegend(visible=False)
MORE = (
    ("correction", "Correction u [mrad]"),
    ("motor_torque", "Torque [N m]"),
    ("imu/acceleration", "IMU, ideal [m/s²]"),
    ("imu/angular_velocity", "Gyro, ideal [rad/s]"),
    ("tracker", "Tracker [mm]"),
)
"""Series behind the first view, each in a tab."""


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Values that the views of one experiment depend on."""

    name: str
    """Prefix of its entities; empty for the only one."""
    factor: float
    """Magnification of the deviations."""
    target: Array
    """(3,) [m], centre of the contour."""
    height: float
    """Height of the robot's upper end above its floor [m]."""
    worst: float
    """Largest value of the learning curves [%]."""
    end: float
    """Time at which the last run ends [s]."""
    is_part: bool
    """Whether deviations are colours."""

    @property
    def time_axis(self) -> rrb.TimeAxis:
        """From 0 to the end, without the margins that the viewer leaves."""
        start, end = (rr.TimeRangeBoundary.absolute(seconds=t) for t in (0.0, self.end))
        return rrb.TimeAxis(view_range=rr.TimeRange(start=start, end=end))

    def entity(self, path: str) -> str:
        """The path below this experiment's prefix."""
        return f"{self.name}/{path}" if self.name else path

    def titled(self, title: str) -> str:
        """The title of a view, with the name of this experiment."""
        return f"{self.name}: {title}" if self.name else title


def blueprint(layouts: Sequence[Layout]) -> rrb.Blueprint:
    """One experiment in three columns, several side by side."""
    several = len(layouts) > 1
    views = rrb.Horizontal(*map(_column, layouts)) if several else _alone(layouts[0])
    return rrb.Blueprint(views, *panels())


def panels() -> list[rrb.BlueprintPart]:
    """The viewer's own panels hidden; the runs play in a loop."""
    return [
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(timeline="time", state="collapsed", play_state="playing", loop_mode="all"),
    ]


def _alone(layout: Layout) -> rrb.Container:
    shares = [3, 2]
    return rrb.Horizontal(
        rrb.Vertical(*_robot(layout), row_shares=shares),
        rrb.Vertical(rrb.Tabs(*_paths(layout)), _learning(layout), row_shares=shares),
        rrb.Vertical(
            _series(layout, "motor_error", "Motor error, arm side of the gear [mrad]", LEGEND),
            _series(layout, "arm_error", "Deviation across the path [µm]", LEGEND),
            rrb.Tabs(*_more(layout)),
        ),
        column_shares=[5, 6, 6],
    )


def _column(layout: Layout) -> rrb.Container:
    return rrb.Vertical(
        rrb.Tabs(*_paths(layout), *_robot(layout), name=layout.name),
        _learning(layout),
        rrb.Tabs(
            _series(layout, "arm_error", layout.titled("deviation across the path [µm]")),
            _series(layout, "motor_error", layout.titled("motor error [mrad]")),
            *_more(layout),
        ),
        row_shares=[5, 3, 3],
        name=layout.name,
    )


def _robot(layout: Layout) -> tuple[rrb.View, rrb.View]:
    """View of the whole robot, from the side and a little above, and the text about the run."""
    reach = layout.height + float(np.hypot(*layout.target[:2]))
    middle = np.array([*(0.5 * layout.target[:2]), 0.5 * layout.height])
    position = middle + reach * np.array([0.35, -1.05, 0.35])
    eye = rrb.EyeControls3D(position=position, look_target=middle)
    origin, name = layout.entity("robot"), layout.titled("Robot")
    about = rrb.TextDocumentView(origin=layout.entity("about"), name="Design and measures")
    return rrb.Spatial3DView(origin=origin, name=name, eye_controls=eye), about


def _paths(layout: Layout) -> tuple[rrb.View, rrb.View]:
    shown = f"×{layout.factor:g}"
    if layout.is_part:
        shown = "coloured" + f", {shown}" * (layout.factor != 1.0)
    every = layout.titled(f"Tool path by iteration, deviation {shown}")
    now = f"This iteration {shown} [mm, y up]"
    return (
        rrb.Spatial2DView(origin=layout.entity("paths"), name=every),
        rrb.Spatial2DView(origin=layout.entity("plane"), name=now),
    )


def _learning(layout: Layout) -> rrb.View:
    return rrb.TimeSeriesView(
        origin=layout.entity("learning"),
        name=layout.titled("Error, % of the first run's; orange: tool, others: motors"),
        plot_legend=NO_LEGEND if layout.name else LEGEND,
        axis_x=layout.time_axis,
        axis_y=rrb.ScalarAxis(range=(0.0, 1.1 * layout.worst)),
    )


def _series(
    layout: Layout, entity: str, title: str, legend: rrb.PlotLegend = NO_LEGEND
) -> rrb.View:
    origin, axis = layout.entity(entity), layout.time_axis
    return rrb.TimeSeriesView(origin=origin, name=title, plot_legend=legend, axis_x=axis)


def _more(layout: Layout) -> list[rrb.View]:
    origin, name = layout.entity("spectrum"), "Spectrum [µm over Hz]"
    spectrum = rrb.BarChartView(origin=origin, name=name, plot_legend=LEGEND)
    return [*(_series(layout, entity, title) for entity, title in MORE), spectrum]
