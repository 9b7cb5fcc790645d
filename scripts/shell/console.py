"""Output of a command: progress on stderr, tables or JSON on stdout, as the options ask.

A table fits the width of the terminal: columns that do not are folded below.
"""

import math
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from rich import progress as bars
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from armside.sim.notes import Note
from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps

from .options import Common

Item = TypeVar("Item")
Result = TypeVar("Result")
NOTHING = "–"
"""Cell of a value that is missing or not finite."""
_KEYS = 3
"""Largest number of leading columns that name the rows in each fold."""
_ANY = 100_000  # more columns than any table has


class Report:
    """Printer of tables, lines and the summary, silent as `--quiet` and `--json` ask."""

    def __init__(self, common: Common) -> None:
        self.common = common

    @contextmanager
    def progress(
        self, task: str, total: float, *, weighted: bool = False
    ) -> Iterator[Callable[..., None]]:
        """A progress bar while the block runs; call what it yields after each of `total` steps. Of
        unequal steps it is called with their weights, and the time that is left is shown."""
        columns = [bars.TextColumn("{task.description}"), bars.BarColumn()]
        columns += [bars.MofNCompleteColumn(), bars.TimeElapsedColumn()]
        if weighted:
            columns[0] = bars.TextColumn("{task.description} {task.percentage:3.0f} %")
            columns[2:] = [bars.TimeRemainingColumn(elapsed_when_finished=True)]
        hidden, console = self.common.quiet or not sys.stderr.isatty(), Console(file=sys.stderr)
        with bars.Progress(
            *columns, console=console, disable=hidden, transient=True, speed_estimate_period=120.0
        ) as bar:
            task_id = bar.add_task(task, total=total)
            yield partial(bar.advance, task_id)

    def each(
        self, task: str, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> list[Result]:
        """function(item) of each item, below a progress bar."""
        found = list[Result]()
        with self.progress(task, len(items)) as step:
            for item in items:
                found.append(function(item))
                step()
        return found

    def table(
        self,
        title: str,
        columns: Sequence[str],
        rows: Sequence[Sequence[Any]],
        *,
        missing: str = "",
    ) -> None:
        """A table on stdout, folded to the width of the terminal: 80 columns, or COLUMNS, if none.
        missing: reason for a number that is not there, printed below a table that lacks one."""
        for table in folded(Console(), title, columns, rows):
            self._print(table)
        if missing and any(cell(value) == NOTHING for row in rows for value in row):
            self.line(f"{NOTHING}: {missing}")

    def notes(self, notes: Iterable[Note | str]) -> None:
        """Limits and faults that changed what was asked, a line each."""
        for note in notes:
            self.line(f"Note: {note if isinstance(note, str) else note.line}")

    def lines(self, texts: Iterable[object]) -> None:
        """A line on stdout for each."""
        for text in texts:
            self.line(str(text))

    def results(self, summary: Any, path: Path) -> None:
        """The end of a command: folder of its results, and the summary for `--json`."""
        self.line(f"Results in {path}")
        self.summary(summary)

    def keep(self, summary: dict[str, Any]) -> None:
        """The summary in the folder `--out`, if one is given, before a reader of stdout leaves."""
        if self.common.out is not None:
            with run_folder(summary, self.common):
                pass

    def kept(self, summary: dict[str, Any], *texts: object) -> None:
        """The end of a command that writes no other files: the summary into `--out`, lines, and the
        summary for `--json`."""
        self.keep(summary)
        self.lines(texts)
        self.summary(summary)

    def texts(self, files: Mapping[str, str], summary: dict[str, Any], *more: str) -> None:
        """Write texts by the names of their files beside the summary, and name them: the end of a
        command."""
        with run_folder(summary, self.common) as folder:
            for name, text in files.items():
                (folder / name).parent.mkdir(exist_ok=True)
                (folder / name).write_text(text, encoding="utf-8")
        self.lines([*(folder.path / name for name in files), *more])
        self.summary(summary)

    def line(self, text: str) -> None:
        """One line on stdout."""
        self._print(Text(text))

    def summary(self, summary: Any) -> None:
        """The summary as JSON on stdout, when `--json` asks for it."""
        if self.common.json:
            sys.stdout.write(dumps(summary))

    def _print(self, renderable: Any) -> None:
        if self.common.quiet or self.common.json:
            return
        Console(soft_wrap=isinstance(renderable, Text)).print(renderable)


@contextmanager
def run_folder(summary: dict[str, Any], common: Common) -> Iterator[RunFolder]:
    """The folder of a run, for its other files; it has summary.json from the start."""
    name = summary["config"]["experiment"]
    with RunFolder(name, seed=common.seed, out=common.out) as folder:
        (folder / "summary.json").write_text(dumps(summary), encoding="utf-8")
        yield folder


def cell(value: Any) -> str:
    """A number with four significant digits, a dash where there is none; anything else as it is."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return NOTHING
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def folded(
    console: Console, title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]
) -> Iterator[Table]:
    """One table, or several with the same leading columns where one would be too wide. Before
    columns are folded, names of columns and texts wrap. No number is ever cut."""
    every = range(len(columns))
    whole = _table(title, columns, rows, every)
    if _width(console, whole).maximum <= console.width:
        yield whole
        return
    names = [_wrapped(name, [row[i] for row in rows]) for i, name in enumerate(columns)]
    keys = list(every[: _naming(rows, len(columns))])
    block = list(keys)
    for index in every[len(keys) :]:
        wider = _table("", names, rows, [*block, index])
        if len(block) > len(keys) and _width(console, wider).minimum > console.width:
            yield _table(title, names, rows, block)
            title, block = "", list(keys)
        block.append(index)
    yield _table(title, names, rows, block)


def _width(console: Console, table: Table) -> Measurement:
    """Columns that the table takes, however few there are."""
    return Measurement.get(console, console.options.update(width=_ANY), table)


def _naming(rows: Sequence[Sequence[Any]], n_columns: int) -> int:
    """Number of leading columns that tell the rows apart; 1 where few columns cannot."""
    for n in range(1, min(_KEYS, n_columns) + 1):
        if len({tuple(map(cell, row[:n])) for row in rows}) == len(rows):
            return n
    return 1


def _wrapped(name: str, values: Sequence[Any]) -> str:
    """The name in lines no longer than its words and the column's values ask for."""
    words = [*map(cell, values), *name.split()]
    return textwrap.fill(name, max(map(len, words)), break_on_hyphens=False)


def _table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]], shown: Sequence[int]
) -> Table:
    table = Table(title=Text(title) if title else None, title_justify="left", title_style="bold")
    for index in shown:
        numeric = all(not isinstance(row[index], str) for row in rows)
        justify = "right" if numeric else "left"
        table.add_column(Text(columns[index]), justify=justify, no_wrap=numeric, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell(row[index])) for index in shown))
    return table
