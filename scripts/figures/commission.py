"""Pictures of a commissioning: friction curves with data, and what the twin leaves of each cut."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armside.sim.robot.mjcf import AXES
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.twin.commission import SENSORS, CommissionedTwin, sensor_of
from armside.sim.twin.correction import friction_constants, lugre
from armside.sim.twin.parameters import Parameters
from armside.sim.twin.recordings import MeasuredCut, SensorName
from armside.sim.twin.sensitivities import Against
from armside.sim.twin.tool_sensor import ToolSensor
from armside.sim.twin.twin import Twin

from .canvas import COLORS, INK, panels

_CURVE = 200
"""Points of a friction curve."""


def friction(file: Path, found: CommissionedTwin, cuts: Sequence[MeasuredCut]) -> None:
    """Friction torque over motor speed, a panel per axis: first cut, and the twin's curve.

    Data are measured torque less all but the friction of the twin, ripple included.
    """
    twin, cut = found.twin, cuts[0]
    loaded = twin.design.load(twin.individual, cut.reference)
    run, gear = loaded.run(cut.correction), loaded.model.drives.gear
    speed = np.gradient(cut.motor_angle, LOG_PERIOD, axis=0) * gear
    every = round(LOG_PERIOD / float(run.truth.time[1]))
    exact = np.gradient(run.truth.motor_angle, float(run.truth.time[1]), axis=0) * gear
    constants = friction_constants(loaded.model)
    simulated = lugre(exact, float(run.truth.time[1]), constants)[::every]
    data = cut.motor_torque - run.motor_torque + simulated
    title = (
        f"Friction of {cut.name}: measured, and the twin's curve of steady sliding.\n"
        "Near zero speed the bristles give way first: points lie beside the curve."
    )
    labels = "motor speed [rad/s]", "torque [N m]"
    look = {"edges": (0.08, 0.985, 0.11, 0.84), "gaps": (0.28, 0.42), "large": True}
    with panels(file, (9.6, 5.4), 2, 3, labels=labels, **look) as grid:
        grid[0].figure.suptitle(title, x=0.02, ha="left", fontsize=10)
        for i, axes in enumerate(grid):
            x, y = speed[cut.moving, i], data[cut.moving, i]
            axes.plot(x, y, ".", ms=2, color=COLORS[5], label="measured")
            x = np.linspace(-1.0, 1.0, _CURVE) * np.abs(x).max()
            coulomb, static, stribeck = constants[2:, i]  # steady-state friction of LuGre
            steady = coulomb + (static - coulomb) * np.exp(-((x / stribeck) ** 2))
            axes.plot(x, np.sign(x) * steady, color=COLORS[1], lw=1.5, label="twin")
            axes.set_title(f"axis {AXES[i]}", color=INK)
        handles = grid[0].get_legend_handles_labels()
        grid[0].figure.legend(*handles, loc="upper right", ncols=2, markerscale=4)


def residuals(file: Path, found: CommissionedTwin, cuts: Sequence[MeasuredCut]) -> None:
    """RMS of the tool sensor's residual in each cut: by design, twin of the others, twin. A panel
    for each sensor."""
    twin, quality = found.twin, found.identified
    measure = "tracker" if twin.sensor == "tracker" else "imu"
    names: list[SensorName] = [sensor_of(cut, measure) for cut in cuts]
    kinds: list[SensorName] = list(dict.fromkeys(names))
    before = np.array(
        [_by_design(twin, cut, SENSORS[n]) for cut, n in zip(cuts, names, strict=True)]
    )
    bars = (
        ("design of the robot", before, COLORS[5]),
        ("twin of the other cuts", quality.held_out, COLORS[4]),
        ("twin", quality.within, COLORS[0]),
    )
    width = max(6.0, 0.9 * len(cuts) + 1.2 * len(kinds))
    edges, gaps = (0.7 / width, 1.0 - 0.1 / width, 0.13, 0.8), (0.25, 0.0)
    with panels(file, (width, 4.0), 1, len(kinds), edges=edges, gaps=gaps) as grid:
        shown = " and ".join(SENSORS[kind].quantity for kind in kinds)
        title = f"{shown.capitalize()} in each cut: measured less predicted, by model"
        grid[0].figure.suptitle(title, x=0.02, ha="left", fontsize=10)
        for axes, kind in zip(grid, kinds, strict=True):
            own = [i for i, name in enumerate(names) if name == kind]
            for i, (label, values, color) in enumerate(bars):
                heights = SENSORS[kind].factor * np.asarray(values)[own]
                place = np.arange(len(own)) + 0.27 * (i - 1)
                drawn = axes.bar(place, heights, 0.25, color=color, label=label)
                said = [f"{h:.{0 if h >= 10.0 else 1}f}" if np.isfinite(h) else "" for h in heights]
                axes.bar_label(drawn, said, fontsize=7, padding=1)
            axes.set_ylabel(f"RMS [{SENSORS[kind].unit}]")
            turned = 20 if len(cuts) > 6 else 0
            axes.set_xticks(np.arange(len(own)), [cuts[i].name for i in own], rotation=turned)
        grid[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=9)


def _by_design(twin: Twin, cut: MeasuredCut, sensor: ToolSensor) -> float:
    """RMS of a cut's residual by the design, but for what is unknown of the sensor itself."""
    own = sensor.own(cut)
    parameters = Parameters((*twin.parameters.blocks, *own)) if own else twin.parameters
    against = Against(twin.design, parameters, cut, sensor)
    left = against.residuals(parameters.mean).tool
    if own:
        columns = against.of_sensor.reshape(left.size, -1)
        fitted = columns @ np.linalg.lstsq(columns, left.ravel(), rcond=1e-9)[0]
        left = left - fitted.reshape(left.shape)
    return float(np.sqrt((left**2).sum(axis=1).mean()))
