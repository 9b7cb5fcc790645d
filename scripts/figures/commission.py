"""Pictures of a commissioning: friction curves with data, and what the twin leaves of each cut."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armside.sim.robot.mjcf import AXES
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.twin.commission import SENSORS, CommissionedTwin
from armside.sim.twin.correction import friction_constants, lugre
from armside.sim.twin.recordings import MeasuredCut
from armside.sim.twin.sensitivities import Against

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
    """RMS of the tool sensor's residual in each cut: by design, twin of the others, twin."""
    twin, quality, sensor = found.twin, found.identified, SENSORS[found.twin.sensor]
    against = (Against(twin.design, twin.parameters, cut, sensor) for cut in cuts)
    before = (one.residuals(twin.parameters.mean).tool for one in against)
    bars = (
        ("design of the robot", [np.sqrt((r**2).sum(axis=1).mean()) for r in before], COLORS[5]),
        ("twin of the other cuts", quality.held_out, COLORS[4]),
        ("twin", quality.within, COLORS[0]),
    )
    width, place = max(6.0, 0.9 * len(cuts) + 1.2), np.arange(len(cuts))
    title = f"{sensor.quantity.capitalize()} in each cut: measured less predicted, by model"
    edges = 0.7 / width, 1.0 - 0.1 / width, 0.13, 0.8
    with panels(file, (width, 4.0), edges=edges) as (axes,):
        axes.figure.suptitle(title, x=0.02, ha="left", fontsize=10)
        for i, (label, values, color) in enumerate(bars):
            heights = sensor.factor * np.asarray(values)
            drawn = axes.bar(place + 0.27 * (i - 1), heights, 0.25, color=color, label=label)
            shown = [f"{h:.{0 if h >= 10.0 else 1}f}" if np.isfinite(h) else "" for h in heights]
            axes.bar_label(drawn, shown, fontsize=7, padding=1)
        axes.set_ylabel(f"RMS [{sensor.unit}]")
        axes.set_xticks(place, [cut.name for cut in cuts], rotation=20 if len(cuts) > 6 else 0)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=9)
