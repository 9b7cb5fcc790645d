"""The figures of chapter 9 from arrays alone, in the look of all our figures."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array

from ...figures import canvas
from ...figures.canvas import COLORS, INK, MARKERS, REFERENCE, logarithmic, whole_numbers
from ..report import Band

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
    paired: bool = False,
    wide: bool = False,
    share_y: bool = True,
) -> None:
    """Curves in panels that share one legend, and their scales where they show one quantity.

    content: panel title: curves. x: of all curves; 0, 1, 2 ... if None. ordered: the curves differ
    by an amount, shown by a sequence of colours; otherwise by kind, shown by colour and marker.
    paired: names are "pose, method": colour and marker are those of the pose, dashes of the method.
    """
    width = 6.2 if len(content) == 1 else 4.4 if wide else 3.1
    height = 2.5 if len(content) > columns else 3.2
    labels = xlabel, ylabel
    with _panels(file, title, content, columns, width, height, *labels, share_y=share_y) as grid:
        for axes, curves in zip(grid, content.values(), strict=True):
            _draw(axes, curves, x, ordered, paired)
            if log:
                logarithmic(axes)
            if x is None:
                whole_numbers(axes.xaxis)
            axes.grid(True)
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
    title, edges = "Largest motor error without learning", (0.08, 0.86, 0.12, 0.88)
    with canvas.panels(file, (8.0, 3.6), title=title, edges=edges) as (axes,):
        at = np.arange(len(positions))
        for i in range(6):
            axes.bar(at + 0.13 * (i - 2.5), errors[:, i], 0.12, color=COLORS[i], label=MOTORS[i])
        axes.set_xticks(at, positions)
        axes.set_ylabel("error (9.5), ∞-norm")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


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
            axes.xaxis.set_major_formatter("{x:g}")
            axes.grid(True)


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
    label = "error at k = 5 over that at k = 0"
    with _panels(file, title, content, 3, 3.3, 2.6, label, "robots", names=8) as grid:
        for axes, (name, values) in zip(grid, content.items(), strict=True):
            axes.hist(values, bins=20, color=COLORS[0])
            left, right = axes.get_xlim()
            if name in bands:
                ends = ((bands[name].low, left), (bands[name].high, right))
                start, stop = (limit if end is None else end for end, limit in ends)
                axes.axvspan(start, stop, color=COLORS[2], alpha=0.18, lw=0, label="band")
                axes.set_xlim(min(left, start), max(right, stop))
            axes.axvline(float(np.median(values)), color=COLORS[1], lw=1.5, label="median")
            whole_numbers(axes.yaxis)


def fields(
    file: Path,
    title: str,
    content: Mapping[str, tuple[Array, NDArray[np.bool_], Sequence[float | None]]],
    rows: Sequence[str],
    columns: Sequence[str],
    *,
    row_label: str,
    column_label: str,
) -> None:
    """A panel for each phenomenon: its value at every (row, column), coloured where it holds.

    content: name: (values, holds), each of shape (rows, columns), and the ends of the band.
    """
    width, height = 0.52 * len(columns) + 0.8, 0.36 * len(rows) + 0.75
    with _panels(file, title, content, 3, width, height, column_label, row_label, names=8) as grid:
        for axes, (values, holds, band) in zip(grid, content.values(), strict=True):
            for (i, j), value in np.ndenumerate(values):
                back, ink = ("#BFE3D6", INK) if holds[i, j] else ("#F6D3C2", "#8A2E00")
                corner = (j - 0.5, i - 0.5)
                axes.add_patch(Rectangle(corner, 1.0, 1.0, facecolor=back, edgecolor="white"))
                axes.text(
                    j, i, _beside(value, band), ha="center", va="center", fontsize=7, color=ink
                )
            axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-0.5, len(rows) - 0.5))
            axes.set_xticks(range(len(columns)), columns)
            axes.set_yticks(range(len(rows)), rows)
        note = "green: as in the thesis; orange: not"
        grid[0].figure.text(0.5, 0.02, note, ha="center", fontsize=8)


def _beside(value: float, band: Sequence[float | None]) -> str:
    """A value with two digits after the point, or more, until it is on its own side of a band."""
    ends = [end for end in band if end is not None]
    shown = (f"{value:.{n}f}" for n in range(2, 7))
    return next(
        (s for s in shown if all(np.sign(float(s) - e) == np.sign(value - e) for e in ends)),
        f"{value}",
    )


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
) -> Iterator[Any]:
    """Panels named by `content`, width x height [inch]. One title above, one legend below.

    names: their font size.
    """
    look: dict[str, Any] = {"edges": (0.75, 0.15, 0.95, 0.62), "gaps": (0.45, 0.62)}
    look |= {"titles": list(content), "labels": (xlabel, ylabel), "sharey": share_y}
    with canvas.tiles(file, len(look["titles"]), columns, (width, height), **look) as grid:
        figure = grid[0].figure
        figure.suptitle(title, x=0.02, y=1.0 - 0.12 / figure.get_figheight(), ha="left", va="top")
        yield grid
        for axes in grid:
            axes.set_title(axes.get_title(loc="left"), fontsize=names)
            axes.yaxis.label.set_size(9)
        handles, found = grid[0].get_legend_handles_labels()
        if found:
            widest = 0.55 + 0.075 * max(map(len, found))  # [inch] at this size of letters
            ncols = max(1, min(len(found), int(figure.get_figwidth() / widest)))
            figure.legend(handles, found, loc="lower center", ncols=ncols)


def _draw(
    axes: Any, curves: Curves, x: ArrayLike | None, ordered: bool, paired: bool = False
) -> None:
    colors = _sequence(len(curves)) if ordered else COLORS
    of_pose, of_method = (list(dict.fromkeys(n.split(", ")[i] for n in curves)) for i in (0, -1))
    for i, (name, values) in enumerate(curves.items()):
        at = np.arange(np.size(values)) if x is None else np.asarray(x)
        kind, dashes = i, 0 if ordered else i // len(COLORS)
        if paired:
            pose, method = name.split(", ")
            kind, dashes = of_pose.index(pose), of_method.index(method)
        color, marker = colors[kind % len(colors)], MARKERS[kind % len(MARKERS)]
        style = LINE_STYLES[dashes % len(LINE_STYLES)]
        look: dict[str, Any] = {"color": color, "marker": marker, "ls": style, "ms": 4, "lw": 1.3}
        axes.plot(at, np.asarray(values), label=name, **look)


def _sequence(n: int) -> list[str]:
    """n colours from dark to light that grow evenly for every eye."""
    return [to_hex(color) for color in colormaps["viridis"](np.linspace(0.0, 0.88, n))]
