"""The figures of chapter 9 from arrays alone, in the look of all our figures."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, MaxNLocator, StrMethodFormatter
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ...figures.laser import COLORS, INK, MARKERS, REFERENCE, new_figure, save
from .bands import Band

Curves = Mapping[str, ArrayLike]
"""Label: values over x."""

LINE_STYLES = ("-", "--", ":", "-.")
MOTORS = tuple(f"motor {i}" for i in range(1, 7))


def panels(
    file: Path,
    title: str,
    content: Mapping[str, Curves],
    x: ArrayLike | None = None,
    *,
    xlabel: str = "iteration k",
    ylabel: str = "",
    log: bool = False,
    columns: int = 3,
    ordered: bool = False,
    wide: bool = False,
    share_y: bool = True,
) -> None:
    """Curves in panels that share one legend, and their scales where they show one quantity.

    content: panel title: curves. x: of all curves; 0, 1, 2 ... if None. ordered: the curves differ
    by an amount, shown by a sequence of colours; otherwise by kind, shown by colour and marker.
    """
    width = 6.2 if len(content) == 1 else 4.4 if wide else 3.1
    height = 2.5 if len(content) > columns else 3.2
    labels = xlabel, ylabel
    with _panels(file, title, content, columns, width, height, *labels, share_y=share_y) as grid:
        for axes, curves in zip(grid, content.values(), strict=True):
            _draw(axes, curves, x, ordered)
            if log:
                axes.set_yscale("log")
                axes.yaxis.set_minor_locator(LogLocator(subs=(2, 5)))
                for formatter in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
                    formatter(StrMethodFormatter("{x:g}"))
            if x is None:
                axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.grid(True, which="major", color="#DDDDDD", lw=0.6)
        if not log:
            tops = [np.nanmax(values) for curves in content.values() for values in curves.values()]
            grid[0].set_ylim(0.0, 1.06 * float(max(tops)))


def by_motor(
    file: Path,
    title: str,
    curves: Mapping[str, Array],
    x: ArrayLike | None = None,
    *,
    log: bool = True,
    **options: Any,
) -> None:
    """A panel for each motor; curves: label: (K, 6) over x. options: as those of `panels`."""
    content = {
        f"Motor {i + 1}": {name: values[:, i] for name, values in curves.items()} for i in range(6)
    }
    panels(file, title, content, x, ylabel="error (9.5), ∞-norm", log=log, **options)


def by_position(file: Path, positions: Sequence[str], errors: Array) -> None:
    """Normalised errors (P, 6) without learning, motors side by side. Thesis Fig. 9.5."""
    figure = new_figure(8.0, 3.6)
    axes = figure.subplots()
    figure.subplots_adjust(left=0.08, right=0.86, bottom=0.12, top=0.88)
    figure.suptitle("Largest motor error without learning", x=0.02, ha="left")
    places = np.arange(len(positions))
    for i in range(6):
        axes.bar(places + 0.13 * (i - 2.5), errors[:, i], 0.12, color=COLORS[i], label=MOTORS[i])
    axes.set_xticks(places, positions)
    axes.set_ylabel("error (9.5), ∞-norm")
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, file)


def criterion(
    file: Path,
    frequency: Array,
    learning: Mapping[str, Mapping[str, Array]],
    bounds: Mapping[str, Array],
) -> None:
    """|1 - L T_u| for several shifts and 1/|Q| for several cutoffs, by model. Thesis Fig. 9.8.

    frequency: (M,) [Hz]. learning: model: shift: (M,). bounds: cutoff: (M,).
    """
    title = "Convergence criterion: each coloured curve must stay below 1/|Q|"
    with _panels(file, title, learning, 2, 4.9, 3.6, "frequency [Hz]", r"$|1 - L\,T_u|$") as grid:
        for axes, curves in zip(grid, learning.values(), strict=True):
            for color, (label, values) in zip(_sequence(len(curves)), curves.items(), strict=True):
                axes.semilogx(frequency, values, color=color, lw=1.4, label=label)
            for style, (label, values) in zip(LINE_STYLES, bounds.items(), strict=False):
                shown = np.where(values < 3.0, values, np.nan)
                axes.semilogx(frequency, shown, color=INK, ls=style, lw=1.2, label=label)
            axes.set(ylim=(0.0, 2.0), xlim=(frequency[0], frequency[-1]))
            axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axes.grid(True, which="major", color="#DDDDDD", lw=0.6)


def simulated(file: Path, sample_time: float, cases: Mapping[str, tuple[Array, Array]]) -> None:
    """Measured response to the correction and its simulation by a model; (N,) [mrad] each."""
    title = "Response of the motor to the correction, and the identified model"
    with _panels(file, title, cases, 2, 4.6, 2.4, "time [s]", "[mrad]") as grid:
        for axes, (measured, model) in zip(grid, cases.values(), strict=True):
            time = sample_time * np.arange(len(measured))
            axes.plot(time, measured, color=REFERENCE, lw=2.2, label="measured, $y_5 - y_0$")
            axes.plot(time, model, color=COLORS[1], lw=1.1, label="model, $T_u u_5$")


def distributions(
    file: Path, title: str, content: Mapping[str, Array], bands: Mapping[str, Band]
) -> None:
    """Histograms of samples, a panel each; a band that should hold them is shaded."""
    with _panels(file, title, content, 3, 3.3, 2.6, "", "robots", names=8) as grid:
        for axes, (name, values) in zip(grid, content.items(), strict=True):
            axes.hist(values, bins=20, color=COLORS[0])
            left, right = axes.get_xlim()
            if name in bands:
                ends = ((bands[name].low, left), (bands[name].high, right))
                start, stop = (limit if end is None else end for end, limit in ends)
                axes.axvspan(start, stop, color=COLORS[2], alpha=0.18, lw=0, label="band")
                axes.set_xlim(min(left, start), max(right, stop))
            axes.axvline(float(np.median(values)), color=COLORS[1], lw=1.5, label="median")
            axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def fields(
    file: Path,
    title: str,
    content: Mapping[str, tuple[Array, NDArray[np.bool_]]],
    rows: Sequence[str],
    columns: Sequence[str],
    *,
    row_label: str,
    column_label: str,
) -> None:
    """A panel for each phenomenon: its value at every (row, column), coloured where it holds.

    content: name: (values, holds), each of shape (rows, columns).
    """
    width, height = 0.52 * len(columns) + 0.8, 0.36 * len(rows) + 0.75
    with _panels(file, title, content, 3, width, height, column_label, row_label, names=8) as grid:
        for axes, (values, holds) in zip(grid, content.values(), strict=True):
            for (i, j), value in np.ndenumerate(values):
                back, ink = ("#BFE3D6", INK) if holds[i, j] else ("#F6D3C2", "#8A2E00")
                corner = (j - 0.5, i - 0.5)
                axes.add_patch(Rectangle(corner, 1.0, 1.0, facecolor=back, edgecolor="white"))
                axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize=7, color=ink)
            axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-0.5, len(rows) - 0.5))
            axes.set_xticks(range(len(columns)), columns)
            axes.set_yticks(range(len(rows)), rows)
        note = "green: as in the thesis; orange: not"
        grid[0].figure.text(0.5, 0.02, note, ha="center", fontsize=8)


@contextmanager
def _panels(
    file: Path,
    title: str,
    content: Iterable[str],
    columns: int,
    width: float,
    height: float,
    xlabel: str = "",
    ylabel: str = "",
    *,
    share_y: bool = False,
    names: float = 9,
) -> Iterator[list[Axes]]:
    """Panels named by `content`, width x height [inch], to draw into; then saved to the file.

    One title above, one legend below, labels at the outer axes. names: their font size.
    """
    titles = list(content)
    columns = min(columns, len(titles))
    rows = -(-len(titles) // columns)
    left, right, bottom, top, gap_x, gap_y = 0.75, 0.15, 0.95, 0.62, 0.45, 0.62
    total_width = left + right + columns * width + (columns - 1) * gap_x
    total_height = bottom + top + rows * height + (rows - 1) * gap_y
    figure = new_figure(total_width, total_height)
    grid = list(figure.subplots(rows, columns, squeeze=False, sharey=share_y).flat)
    figure.subplots_adjust(
        left=left / total_width,
        right=1.0 - right / total_width,
        bottom=bottom / total_height,
        top=1.0 - top / total_height,
        wspace=gap_x / width,
        hspace=gap_y / height,
    )
    figure.suptitle(title, x=0.02, y=1.0 - 0.12 / figure.get_figheight(), ha="left", va="top")
    used = grid[: len(titles)]
    yield used
    for axes, name in zip(used, titles, strict=True):
        axes.set_title(name, loc="left", fontsize=names)
    for axes in used[-columns:]:
        axes.set_xlabel(xlabel)
    for axes in used[::columns]:
        axes.set_ylabel(ylabel, fontsize=9)
    for axes in grid[len(titles) :]:
        axes.set_visible(False)
    _legend(figure, used[0])
    save(figure, file)


def _legend(figure: Figure, axes: Axes) -> None:
    """One legend below all panels, as many columns as fit."""
    handles, labels = axes.get_legend_handles_labels()
    if not labels:
        return
    widest = 0.55 + 0.075 * max(map(len, labels))  # [inch] at this size of letters
    columns = max(1, min(len(labels), int(figure.get_figwidth() / widest)))
    figure.legend(handles, labels, loc="lower center", ncols=columns, frameon=False, fontsize=8)


def _draw(axes: Axes, curves: Curves, x: ArrayLike | None, ordered: bool) -> None:
    colors = _sequence(len(curves)) if ordered else COLORS
    for i, (name, values) in enumerate(curves.items()):
        at = np.arange(np.size(values)) if x is None else np.asarray(x)
        color, marker = colors[i % len(colors)], MARKERS[i % len(MARKERS)]
        style = LINE_STYLES[0 if ordered else i // len(COLORS) % len(LINE_STYLES)]
        look: dict[str, Any] = {"color": color, "marker": marker, "ls": style, "ms": 4, "lw": 1.3}
        axes.plot(at, np.asarray(values), label=name, **look)


def _sequence(n: int) -> list[str]:
    """n colours from dark to light that grow evenly for every eye."""
    return [to_hex(color) for color in colormaps["viridis"](np.linspace(0.0, 0.88, n))]
