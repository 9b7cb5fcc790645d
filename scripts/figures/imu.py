"""Figures of thesis chapter 5 as PNG files, from arrays alone."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from armside.arrays import Array

from .canvas import COLORS, INK, REFERENCE, new_figure, panels

AXES = "xyz"
VECTORS = {
    "angular_velocity": ("Angular velocity", "ω", "rad/s"),
    "acceleration": ("Linear acceleration", "a", "m/s²"),
}
"""Measured vectors: name, symbol and unit."""
SHADE = "#EFEFEF"
WIDE = "#A9D5F0"
"""Of a wide line under a thin one: where the two agree, both are seen."""
LEAST = 0.15
"""Smallest range of a motor's panel over the largest, so that noise is not magnified."""
AT_REST = 1e-3
"""Range of a motor that counts as at rest, over the largest."""
STACKED = 3
"""Most panels in one column."""
Curve = tuple[Array, dict[str, Any]]
"""Values (K, 3) and options of `plot`."""


@contextmanager
def _stack(
    file: Path, title: str, ylabel: str, x: Array, *curves: Curve, xlabel: str = "Time [s]"
) -> Iterator[Any]:
    """Curves over x, a panel for each axis of a vector. ylabel: with {} for the axis."""
    look: dict[str, Any] = {"labels": (xlabel, ""), "gaps": (None, 0.15), "sharex": True}
    edges = (0.11, 0.98, 0.1, 0.91)
    with panels(file, (8.0, 5.6), 3, title=title, edges=edges, **look) as grid:
        for i, axes in enumerate(grid):
            axes.set_ylabel(ylabel.format(AXES[i]))
            for values, options in curves:
                axes.plot(x, values[:, i], **options)
        yield grid


def rest(file: Path, time: Array, acceleration: Array, motors_on_at: float) -> None:
    """Accelerations (K, 3) [m/s^2] at rest, the motors off and then on. Thesis Fig. 5.2."""
    title, curve = "Acceleration at rest: motors off, then on", (acceleration, {"lw": 0.5})
    with _stack(file, title, "a$_{}$ [m/s²]", time, curve) as grid:
        for axes in grid:
            axes.axvline(motors_on_at, color=INK, lw=0.8, ls="--")


def spectrum(file: Path, frequency: Array, off: Array, on: Array) -> None:
    """Power spectra of the accelerometer at rest, (F, 3) [(m/s^2)^2/Hz]. Thesis 5.1.1."""
    title, ylabel = "Acceleration at rest: power spectrum", "{} [(m/s²)²/Hz]"
    without = off[1:], {"color": REFERENCE, "lw": 1.0, "label": "motors off"}
    powered = on[1:], {"color": COLORS[0], "lw": 1.0, "label": "motors on"}
    curves, xlabel = (without, powered), "Frequency [Hz]"
    with _stack(file, title, ylabel, frequency[1:], *curves, xlabel=xlabel) as grid:
        for axes in grid:
            axes.set_yscale("log")
        grid[0].legend(ncols=2)


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
    columns = 1 if len(moving) <= STACKED else 2
    look: dict[str, Any] = {"labels": ("Time [s]", ""), "gaps": (0.2, 0.32), "sharex": True}
    look |= {"title": "Logged motor angles, arm side", "edges": (0.08, 0.98, 0.09, 0.9)}
    with panels(file, (9.0, 6.4), -(-len(moving) // columns), columns, **look) as grid:
        if len(moving) < len(moved):
            names = ", ".join(str(i + 1) for i in np.flatnonzero(resting))
            unit = "µrad, µm of a slide" if sliding[resting].any() else "µrad"
            text = f"Motors at rest, within {1e6 * moved[resting].max():.0f} {unit}: {names}"
            grid[0].figure.text(0.98, 0.955, text, ha="right", fontsize=9)
        for k, (i, axes) in enumerate(zip(moving, grid, strict=False)):
            axes.plot(time, angle[:, i], lw=1.0)
            widest = float(moved[sliding == sliding[i]].max())
            half = 0.56 * max(float(moved[i]), LEAST * widest, 1e-6)
            axes.set(title=f"Motor {i + 1}", ylim=_around(angle[:, i], half))
            if sliding[i]:
                axes.set_ylabel("position [m]", fontsize=8)
            elif k % columns == 0:
                axes.set_ylabel("angle [rad]", fontsize=8)
        for axes in grid[len(moving) :]:
            axes.set_visible(False)


def _around(values: Array, half: float) -> tuple[float, float]:
    """Limits about the middle of some values."""
    middle = 0.5 * float(values.min() + values.max())
    return middle - half, middle + half


def path(file: Path, position: Array) -> None:
    """Path of the IMU (N, 3) [m], base axes. Thesis Fig. 5.6."""
    figure = new_figure(6.4, 5.6)
    axes = figure.add_subplot(projection="3d")
    axes.plot(*position.T, color=COLORS[0], lw=1.0)
    axes.plot(*position[0], "o", color=COLORS[1], ms=6, label="start, and its direction")
    away = position - position[0]
    far = np.linalg.norm(away, axis=1)
    first_leg = away[np.argmax(far >= 0.3 * far.max())]
    axes.quiver(*position[0], *first_leg, color=COLORS[1], lw=2.5, arrow_length_ratio=0.4)
    axes.legend(loc="upper right")
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
    half = 0.55 * max(float(np.ptp(predicted, axis=0).max()), 1e-3)
    furthest = 1.1e3 * max(float(np.abs(tool - predicted).max()), 1e-6)
    look: dict[str, Any] = {"labels": ("Time [s]", ""), "gaps": (0.25, 0.2), "sharex": True}
    look |= {"title": "Position of TCP0, base axes", "edges": (0.09, 0.98, 0.09, 0.9)}
    with panels(file, (9.0, 6.4), 3, 2, **look) as grid:
        for i, (left, right) in enumerate(grid.reshape(3, 2)):
            left.plot(time, predicted[:, i], color=WIDE, lw=4.0, label="D-H of motor angles")
            left.plot(time, tool[:, i], color=COLORS[1], lw=1.0, label="tool")
            left.set(ylabel=f"{AXES[i]} [m]", ylim=_around(predicted[:, i], half))
            right.set_ylim(-furthest, furthest)
            right.plot(time, 1e3 * (tool - predicted)[:, i], color=INK, lw=0.8)
            right.set_ylabel("difference [mm]", fontsize=8)
        _legend_beside_title(grid[0])


def vector(file: Path, time: Array, measured: Array, predicted: Array, *, quantity: str) -> None:
    """A quantity of `VECTORS` of the IMU in base axes, (K, 3). Thesis Figs. 5.8, 5.9."""
    title, symbol, unit = VECTORS[quantity]
    wide = predicted, {"color": WIDE, "lw": 4.0, "label": "predicted"}
    thin = measured, {"color": COLORS[1], "lw": 0.9, "label": "measured"}
    title, ylabel = f"{title} of the IMU, base axes", f"{symbol}$_{{}}$ [{unit}]"
    with _stack(file, title, ylabel, time, wide, thin) as grid:
        _legend_beside_title(grid[0])


def comparison(
    folder: Any, suffix: str, seen: Any, shown: Any, judged: Any, window_rms: Array, window: float
) -> None:
    """Measured and predicted vectors and the moving RMS (K, 3) of an `ImuComparison`.

    shown, judged: rows of the vectors and of the error.
    """
    for quantity in VECTORS:
        sides = (getattr(seen, f"{quantity}_{side}")[shown] for side in ("measured", "predicted"))
        file = folder / f"{quantity.replace('_', '-')}{suffix}.png"
        vector(file, seen.time[shown], *sides, quantity=quantity)
    file = folder / f"acceleration-error{suffix}.png"
    acceleration_error(file, seen.time[judged], {"": window_rms[judged]}, window)


def _legend_beside_title(axes: Any) -> None:
    """Legend of the curves of a panel in the figure's upper right corner, over no curve."""
    axes.figure.legend(*axes.get_legend_handles_labels(), ncols=2, loc="upper right")


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
    title = f"Acceleration error: RMS over {window:g} s"
    drawn = ((values, {"lw": 1.2, "label": label}) for label, values in curves.items())
    top = 1.08 * max(float(values.max()) for values in curves.values())
    with _stack(file, title, "a$_{}$ [m/s²]", time, *drawn) as grid:
        for axes in grid:
            for part in shaded.values():
                axes.axvspan(*part, color=SHADE, lw=0)
            axes.set_ylim(0.0, top)
        for label, part in shaded.items():
            middle = float(np.mean(part))
            grid[0].text(middle, 0.93 * top, label, ha="center", va="top", fontsize=8, color=INK)
        if len(curves) > 1:
            grid[-1].legend(ncols=2)


def clocks(
    file: Path, time: Array, measured: Array, predicted: Array, offset: float, errors: Array
) -> None:
    """Motion that synchronises the clocks, and errors of the offset of others. Thesis 5.3.1.

    time: (K,) [s], of the robot. measured, predicted: (K,) [rad/s]. offset: of the IMU's clock [s].
    errors: of the offsets estimated for other IMUs (n,) [s].
    """
    steepest = int(np.abs(np.diff(predicted)).argmax())
    shown = slice(max(steepest - 4, 0), steepest + 5)
    apart = f"Its steepest part, {1e3 * abs(offset):.1f} ms apart"
    titles = "The movement", apart, f"Offset found, {len(errors)} others"
    look: dict[str, Any] = {"title": "Synchronisation of the clocks", "titles": titles}
    look |= {"edges": (0.07, 0.985, 0.15, 0.8), "gaps": (0.32, None), "width_ratios": (3, 3, 1.5)}
    with panels(file, (10.0, 3.4), 1, 3, **look) as (whole, near, found):
        for axes in (whole, near):
            axes.plot(time, predicted, color=INK, lw=2.0, label="predicted from motor angles")
            axes.plot(time - offset, measured, color=COLORS[1], lw=1.0, label="IMU, its own clock")
            axes.plot(time, measured, color=COLORS[0], lw=1.2, ls="--", label="IMU, offset found")
            axes.set_xlabel("Time [s]")
        whole.set_ylabel("ω$_z$ [rad/s]")
        ylim = predicted[shown].min(), predicted[shown].max()
        near.set(xlim=(time[shown][0], time[shown][-1]), ylim=ylim)
        near.legend()
        found.plot(1e3 * errors, np.arange(len(errors)), "o", ms=4)
        found.axvline(0.0, color=INK, lw=0.8)
        found.set(xlim=(-1.0, 1.0), xlabel="error [ms]", yticks=[])
