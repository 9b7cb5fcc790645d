"""Figures of thesis chapter 5 as PNG files, from arrays alone."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from armside.arrays import Array

from .laser import COLORS, INK, REFERENCE, new_figure, save

AXES = "xyz"
SHADE = "#EFEFEF"
WIDE = "#A9D5F0"
"""Of a wide line under a thin one: where the two agree, both are seen."""
LEAST = 0.15
"""Smallest range of a motor's panel over the largest, so that noise is not magnified."""
AT_REST = 1e-3
"""Range of a motor that counts as at rest, over the largest."""
STACKED = 3
"""Most panels in one column."""


def rest(file: Path, time: Array, acceleration: Array, motors_on_at: float) -> None:
    """Accelerations at rest, the motors off and then on. Thesis Fig. 5.2.

    time: (K,) [s]. acceleration: (K, 3) [m/s^2].
    """
    with _stack(file, "Acceleration at rest: motors off, then on", "Time [s]") as panels:
        for axes, name, values in zip(panels, AXES, acceleration.T, strict=True):
            axes.plot(time, values, color=COLORS[0], lw=0.5)
            axes.axvline(motors_on_at, color=INK, lw=0.8, ls="--")
            axes.set_ylabel(f"a$_{name}$ [m/s²]")


def spectrum(file: Path, frequency: Array, off: Array, on: Array) -> None:
    """Power spectra of the accelerometer at rest, (F, 3) [(m/s^2)^2/Hz]. Thesis 5.1.1."""
    with _stack(file, "Acceleration at rest: power spectrum", "Frequency [Hz]") as panels:
        for i, axes in enumerate(panels):
            axes.semilogy(frequency[1:], off[1:, i], color=REFERENCE, lw=1.0, label="motors off")
            axes.semilogy(frequency[1:], on[1:, i], color=COLORS[0], lw=1.0, label="motors on")
            axes.set_ylabel(f"{AXES[i]} [(m/s²)²/Hz]")
        panels[0].legend(frameon=False, fontsize=8, ncols=2)


def motor_angles(
    file: Path, time: Array, angle: Array, slides: Sequence[bool] | None = None
) -> None:
    """Logged motor angles (N, n) [rad], arm side, each on its own scale. Thesis Figs. 5.4, 5.5.

    Motors at rest have no panel; the title names them, and how far they moved. slides: (n,), True
    for each prismatic axis, whose values are in [m]; none if None.
    """
    moved = np.ptp(angle, axis=0)
    sliding = np.zeros(len(moved), dtype=bool) if slides is None else np.array(slides)
    resting = moved <= AT_REST * moved.max()
    moving = np.flatnonzero(~resting) if moved.any() else np.arange(len(moved))
    n_columns = 1 if len(moving) <= STACKED else 2
    figure = new_figure(9.0, 6.4)
    figure.suptitle("Logged motor angles, arm side", x=0.02, ha="left")
    if len(moving) < len(moved):
        names = ", ".join(str(i + 1) for i in np.flatnonzero(resting))
        unit = "µrad, µm of a slide" if sliding[resting].any() else "µrad"
        said = f"Motors at rest, within {1e6 * moved[resting].max():.0f} {unit}: {names}"
        figure.text(0.98, 0.955, said, ha="right", fontsize=9)
    grid = figure.subplots(-(-len(moving) // n_columns), n_columns, sharex=True, squeeze=False)
    figure.subplots_adjust(left=0.08, right=0.98, bottom=0.09, top=0.9, hspace=0.32, wspace=0.2)
    for k, (i, axes) in enumerate(zip(moving, grid.flat, strict=False)):
        axes.plot(time, angle[:, i], color=COLORS[0], lw=1.0)
        axes.set_title(f"Motor {i + 1}", loc="left", fontsize=9)
        middle = 0.5 * float(angle[:, i].min() + angle[:, i].max())
        widest = float(moved[sliding == sliding[i]].max())
        half = 0.56 * max(float(moved[i]), LEAST * widest, 1e-6)
        axes.set_ylim(middle - half, middle + half)
        if sliding[i]:
            axes.set_ylabel("position [m]", fontsize=8)
        elif k % n_columns == 0:
            axes.set_ylabel("angle [rad]", fontsize=8)
    for axes in grid.flat[len(moving) :]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel("Time [s]")
    save(figure, file)


def path(file: Path, position: Array) -> None:
    """Path of the IMU (N, 3) [m], base axes. Thesis Fig. 5.6."""
    figure = new_figure(6.4, 5.6)
    axes = figure.add_subplot(projection="3d")
    axes.plot(*position.T, color=COLORS[0], lw=1.0)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title="Performed motion of the IMU")
    size = np.maximum(np.ptp(position, axis=0), 0.05)
    axes.set_box_aspect(size)
    axes.view_init(elev=25, azim=-60)
    for name, part in zip(AXES, size / size.max(), strict=True):  # ticks as far apart on all axes
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(max(1, round(4.0 * part))))
    figure.savefig(file, metadata={"Software": None})


def position(file: Path, time: Array, tool: Array, predicted: Array) -> None:
    """True TCP0, TCP0 by D-H from the motor angles, and the difference. Thesis Fig. 5.7.

    tool, predicted: (N, 3) [m]. All axes have the same scale.
    """
    figure = new_figure(9.0, 6.4)
    figure.suptitle("Position of TCP0, base axes", x=0.02, ha="left")
    grid = figure.subplots(3, 2, sharex=True)
    half = 0.55 * max(float(np.ptp(predicted, axis=0).max()), 1e-3)
    furthest = 1.1e3 * max(float(np.abs(tool - predicted).max()), 1e-6)
    figure.subplots_adjust(left=0.09, right=0.98, bottom=0.09, top=0.9, hspace=0.2, wspace=0.25)
    for i, (left, right) in enumerate(grid):
        left.plot(time, predicted[:, i], color=WIDE, lw=4.0, label="D-H of motor angles")
        left.plot(time, tool[:, i], color=COLORS[1], lw=1.0, label="tool")
        left.set_ylabel(f"{AXES[i]} [m]")
        middle = 0.5 * float(predicted[:, i].min() + predicted[:, i].max())
        left.set_ylim(middle - half, middle + half)
        right.set_ylim(-furthest, furthest)
        right.plot(time, 1e3 * (tool - predicted)[:, i], color=INK, lw=0.8)
        right.set_ylabel("difference [mm]", fontsize=8)
    _legend_beside_title(grid[0, 0])
    for axes in grid[-1]:
        axes.set_xlabel("Time [s]")
    save(figure, file)


def angular_velocity(file: Path, time: Array, measured: Array, predicted: Array) -> None:
    """Angular velocity of the IMU in base axes, (K, 3) [rad/s]. Thesis Fig. 5.8."""
    title = "Angular velocity of the IMU, base axes"
    _both_sides(file, title, time, measured, predicted, "ω", "rad/s")


def acceleration(file: Path, time: Array, measured: Array, predicted: Array) -> None:
    """Acceleration of the IMU in base axes, without gravity, (K, 3) [m/s^2]. Thesis Fig. 5.9."""
    title = "Linear acceleration of the IMU, base axes"
    _both_sides(file, title, time, measured, predicted, "a", "m/s²")


def _legend_beside_title(axes: Axes) -> None:
    """Legend of the curves of a panel in the figure's upper right corner, over no curve."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    names = axes.get_legend_handles_labels()
    figure.legend(*names, frameon=False, fontsize=8, ncols=2, loc="upper right")


def _both_sides(
    file: Path, title: str, time: Array, measured: Array, predicted: Array, symbol: str, unit: str
) -> None:
    with _stack(file, title, "Time [s]") as panels:
        for i, axes in enumerate(panels):
            axes.plot(time, predicted[:, i], color=WIDE, lw=4.0, label="predicted")
            axes.plot(time, measured[:, i], color=COLORS[1], lw=0.9, label="measured")
            axes.set_ylabel(f"{symbol}$_{AXES[i]}$ [{unit}]")
        _legend_beside_title(panels[0])


def acceleration_error(
    file: Path,
    time: Array,
    curves: Mapping[str, Array],
    window: float,
    shaded: Mapping[str, tuple[float, float]] = MappingProxyType({}),
) -> None:
    """Moving RMS of the acceleration error. Thesis Fig. 5.10.

    curves: label: (K, 3) [m/s^2]. shaded: label: a part of the motion, from and to [s].
    """
    with _stack(file, f"Acceleration error: RMS over {window:g} s", "Time [s]") as panels:
        top = 1.08 * max(float(values.max()) for values in curves.values())
        for i, axes in enumerate(panels):
            for part in shaded.values():
                axes.axvspan(*part, color=SHADE, lw=0)
            for (label, values), color in zip(curves.items(), COLORS, strict=False):
                axes.plot(time, values[:, i], color=color, lw=1.2, label=label)
            axes.set_ylabel(f"a$_{AXES[i]}$ [m/s²]")
            axes.set_ylim(0.0, top)
        for label, part in shaded.items():
            middle = float(np.mean(part))
            panels[0].text(middle, 0.93 * top, label, ha="center", va="top", fontsize=8, color=INK)
        if len(curves) > 1:
            panels[-1].legend(frameon=False, fontsize=8, ncols=2)


def clocks(
    file: Path, time: Array, measured: Array, predicted: Array, offset: float, errors: Array
) -> None:
    """Motion that synchronises the clocks, and errors of the offset of others. Thesis 5.3.1.

    time: (K,) [s], of the robot. measured, predicted: (K,) [rad/s]. offset: of the IMU's clock [s].
    errors: of the offsets estimated for other IMUs (n,) [s].
    """
    figure = new_figure(10.0, 3.4)
    figure.suptitle("Synchronisation of the clocks", x=0.02, ha="left")
    whole, near, found = figure.subplots(1, 3, width_ratios=(3, 3, 1.5))
    figure.subplots_adjust(left=0.07, right=0.985, bottom=0.15, top=0.8, wspace=0.32)
    steepest = int(np.abs(np.diff(predicted)).argmax())
    for axes in (whole, near):
        axes.plot(time, predicted, color=INK, lw=2.0, label="predicted from motor angles")
        axes.plot(time - offset, measured, color=COLORS[1], lw=1.0, label="IMU, its own clock")
        axes.plot(time, measured, color=COLORS[0], lw=1.2, ls="--", label="IMU, offset found")
        axes.set_xlabel("Time [s]")
    whole.set_ylabel("ω$_z$ [rad/s]")
    whole.set_title("The movement", loc="left", fontsize=9)
    shown = slice(max(steepest - 4, 0), steepest + 5)
    near.set_xlim(time[shown][0], time[shown][-1])
    near.set_ylim(predicted[shown].min(), predicted[shown].max())
    near.set_title(f"Its steepest part, {1e3 * abs(offset):.1f} ms apart", loc="left", fontsize=9)
    near.legend(frameon=False, fontsize=8)
    found.plot(1e3 * errors, np.arange(len(errors)), "o", color=COLORS[0], ms=4)
    found.axvline(0.0, color=INK, lw=0.8)
    found.set(xlim=(-1.0, 1.0), xlabel="error [ms]", yticks=[])
    found.set_title(f"Offset found, {len(errors)} others", loc="left", fontsize=9)
    save(figure, file)


@contextmanager
def _stack(file: Path, title: str, x_label: str) -> Iterator[Sequence[Axes]]:
    """Three panels above each other with a common x axis, saved when the block ends well."""
    figure = new_figure(8.0, 5.6)
    figure.suptitle(title, x=0.02, ha="left")
    panels: Sequence[Axes] = figure.subplots(3, 1, sharex=True)
    figure.subplots_adjust(left=0.11, right=0.98, bottom=0.1, top=0.91, hspace=0.15)
    panels[-1].set_xlabel(x_label)
    yield panels
    save(figure, file)
