"""The figures of thesis chapter 5 as PNG files, from arrays alone."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from .figures import COLORS, INK, REFERENCE, new_figure, save

Array = NDArray[np.float64]

AXES = "xyz"


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


def motor_angles(file: Path, time: Array, angle: Array) -> None:
    """Logged motor angles (N, 6) [rad], arm side. Thesis Figs. 5.4 and 5.5."""
    figure = new_figure(9.0, 6.4)
    figure.suptitle("Logged motor angles, arm side", x=0.02, ha="left")
    grid = figure.subplots(3, 2, sharex=True)
    figure.subplots_adjust(left=0.08, right=0.98, bottom=0.09, top=0.9, hspace=0.32, wspace=0.2)
    for i, axes in enumerate(grid.flat):
        axes.plot(time, angle[:, i], color=COLORS[0], lw=1.0)
        axes.set_title(f"Motor {i + 1}", loc="left", fontsize=9)
        axes.set_ylabel("angle [rad]", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("Time [s]")
    save(figure, file)


def path(file: Path, position: Array) -> None:
    """Way of the IMU (N, 3) [m], base axes. Thesis Fig. 5.6."""
    figure = new_figure(6.4, 5.6)
    axes = figure.add_subplot(projection="3d")
    axes.plot(*position.T, color=COLORS[0], lw=1.0)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title="Performed motion of the IMU")
    axes.set_box_aspect(np.maximum(np.ptp(position, axis=0), 0.05))
    axes.view_init(elev=25, azim=-60)
    figure.savefig(file, metadata={"Software": None})


def position(file: Path, time: Array, tool: Array, predicted: Array) -> None:
    """TCP0 as it was and by D-H from the motor angles, and the difference. Thesis Fig. 5.7.

    tool, predicted: (N, 3) [m].
    """
    figure = new_figure(9.0, 6.4)
    figure.suptitle("Position of TCP0, base axes", x=0.02, ha="left")
    grid = figure.subplots(3, 2, sharex=True)
    figure.subplots_adjust(left=0.09, right=0.98, bottom=0.09, top=0.9, hspace=0.2, wspace=0.25)
    for i, (left, right) in enumerate(grid):
        left.plot(time, tool[:, i], color=COLORS[1], lw=1.8, label="tool")
        left.plot(time, predicted[:, i], color=COLORS[0], lw=0.9, label="D-H of motor angles")
        left.set_ylabel(f"{AXES[i]} [m]")
        right.plot(time, 1e3 * (tool - predicted)[:, i], color=INK, lw=0.8)
        right.set_ylabel("difference [mm]", fontsize=8)
    grid[0, 0].legend(frameon=False, fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("Time [s]")
    save(figure, file)


def measured_and_predicted(
    file: Path, time: Array, measured: Array, predicted: Array, title: str, symbol: str, unit: str
) -> None:
    """A vector of the IMU in base axes, (K, 3) each. Thesis Figs. 5.8 and 5.9."""
    with _stack(file, title, "Time [s]") as panels:
        for i, axes in enumerate(panels):
            axes.plot(time, measured[:, i], color=COLORS[1], lw=1.4, label="measured")
            axes.plot(time, predicted[:, i], color=COLORS[0], lw=0.8, label="predicted")
            axes.set_ylabel(f"{symbol}$_{AXES[i]}$ [{unit}]")
        panels[0].legend(frameon=False, fontsize=8, ncols=2)


def acceleration_error(file: Path, time: Array, window_rms: Array, window: float) -> None:
    """Moving RMS of the acceleration error, (K, 3) [m/s^2]. Thesis Fig. 5.10."""
    title = f"Acceleration error: RMS over {window:g} s"
    with _stack(file, title, "Time [s]") as panels:
        top = 1.08 * float(window_rms.max())
        for i, axes in enumerate(panels):
            axes.plot(time, window_rms[:, i], color=COLORS[0], lw=1.2)
            axes.set_ylabel(f"a$_{AXES[i]}$ [m/s²]")
            axes.set_ylim(0.0, top)


@contextmanager
def _stack(file: Path, title: str, x_label: str) -> Iterator[Sequence[Axes]]:
    """Three panels above each other with one axis of x, saved when the block ends well."""
    figure = new_figure(8.0, 5.6)
    figure.suptitle(title, x=0.02, ha="left")
    panels: Sequence[Axes] = figure.subplots(3, 1, sharex=True)
    figure.subplots_adjust(left=0.11, right=0.98, bottom=0.1, top=0.91, hspace=0.15)
    panels[-1].set_xlabel(x_label)
    yield panels
    save(figure, file)
