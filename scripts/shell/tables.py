"""Tables that fit the width of the terminal: columns that do not are folded below."""

import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

NOTHING = "–"
"""Cell of a value that is missing or not finite."""
_KEYS = 3
"""Largest number of leading columns that name the rows in each fold."""
_ANY = 100_000  # more columns than any table has


def cell(value: Any) -> str:
    """A number with four significant digits, a dash where there is none; anything else as it is."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return NOTHING
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def folded(
    console: Console, title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]
) -> Iterator[Table]:
    """One table, or several with the same leading columns where one would be too wide.

    Before columns are folded, names of columns and texts wrap. No number is ever cut.
    """
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
    """Text columns to the left, numbers to the right."""
    table = Table(title=Text(title) if title else None, title_justify="left", title_style="bold")
    for index in shown:
        numeric = all(not isinstance(row[index], str) for row in rows)
        justify = "right" if numeric else "left"
        table.add_column(Text(columns[index]), justify=justify, no_wrap=numeric, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell(row[index])) for index in shown))
    return table
