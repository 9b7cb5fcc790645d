"""Pictures of a commissioning: friction curves with data, and what the twin leaves of each cut."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from armside.arrays import Array
from armside.sim.robot.mjcf import AXES
from armside.sim.robot.virtual_robot import LOG_PERIOD
from armside.sim.twin.commission import SENSORS, CommissionedTwin
from armside.sim.twin.learning import friction_constants, lugre
from armside.sim.twin.recordings import MeasuredCut
from armside.sim.twin.sensitivities import Against

from .laser import COLORS, INK, new_figure, save

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
    figure = new_figure(9.6, 5.4)
    panels = figure.subplots(2, 3)
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.11, top=0.84, wspace=0.28, hspace=0.42)
    title = "Friction of {}: measured, and the twin's curve of steady sliding.\n{}"
    before = "Near zero speed the bristles give way first: points lie beside the curve."
    figure.suptitle(title.format(cut.name, before), x=0.02, ha="left", fontsize=10)
    for i, axes in enumerate(panels.flat):
        on = cut.moving
        axes.plot(speed[on, i], data[on, i], ".", ms=2, color=COLORS[5], label="measured")
        x = np.linspace(-1.0, 1.0, _CURVE) * np.abs(speed[on, i]).max()
        axes.plot(x, _stribeck(x, constants[:, i]), color=COLORS[1], lw=1.5, label="twin")
        axes.set_title(f"axis {AXES[i]}", loc="left", color=INK)
        if i % 3 == 0:
            axes.set_ylabel("torque [N m]")
        if i >= 3:
            axes.set_xlabel("motor speed [rad/s]")
    handles, labels = panels.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=2, frameon=False, markerscale=4)
    save(figure, file)


def _stribeck(speed: Array, constants: Array) -> Array:
    """Steady-state friction of LuGre."""
    _, _, coulomb, static, stribeck = constants
    return np.sign(speed) * (coulomb + (static - coulomb) * np.exp(-((speed / stribeck) ** 2)))


def residuals(file: Path, found: CommissionedTwin, cuts: Sequence[MeasuredCut]) -> None:
    """RMS of the tool sensor's residual in each cut: by design, twin of the others, twin."""
    twin, quality, sensor = found.twin, found.identified.quality, SENSORS[found.twin.sensor]
    before = [
        _rms(
            Against(twin.design, twin.parameters, cut, sensor).residuals(twin.parameters.mean).tool
        )
        for cut in cuts
    ]
    bars = (
        ("design of the robot", before, COLORS[5]),
        ("twin of the other cuts", quality.held_out, COLORS[4]),
        ("twin", quality.within, COLORS[0]),
    )
    width = max(6.0, 0.9 * len(cuts) + 1.2)
    figure = new_figure(width, 4.0)
    axes = figure.add_subplot()
    figure.subplots_adjust(left=0.7 / width, right=1.0 - 0.1 / width, bottom=0.13, top=0.8)
    title = (
        f"{sensor.quantity.capitalize()} beyond that of its motors: what a model does not explain"
    )
    figure.suptitle(title, x=0.02, ha="left", fontsize=10)
    place = np.arange(len(cuts))
    for i, (label, values, color) in enumerate(bars):
        heights = sensor.factor * np.asarray(values)
        bars_of = axes.bar(place + 0.27 * (i - 1), heights, 0.25, color=color, label=label)
        axes.bar_label(bars_of, [_short(height) for height in heights], fontsize=7, padding=1)
    axes.set_ylabel(f"RMS [{sensor.unit}]")
    axes.set_xticks(place, [cut.name for cut in cuts], rotation=20 if len(cuts) > 6 else 0)
    axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=9)
    save(figure, file)


def _short(height: float) -> str:
    if not np.isfinite(height):
        return ""
    return f"{height:.0f}" if height >= 10.0 else f"{height:.1f}"


def _rms(residual: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(residual**2, axis=1))))
