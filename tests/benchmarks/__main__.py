"""`python -m tests.benchmarks [NAME ...]`: execution times on this machine, beside other libraries.

`make bench` calls it. A benchmark is a file with a function `measured() -> Sequence[Row]`.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from .. import evidence
from ._timing import Row

COLUMNS = ("", "ours", "peer", "theirs", "ours / theirs")


def main(words: Sequence[str] | None = None) -> int:
    """Measure the benchmarks, and print medians in seconds and ratios taken in turns."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", help="benchmarks [default: all]")
    parser.add_argument("--json", action="store_true", help="print JSON")
    asked = parser.parse_args(words)
    names = evidence.chosen("benchmarks", asked.names)
    bar, step = evidence.progress("measuring", len(names))
    found = dict[str, Sequence[Row]]()
    with bar:
        for name in names:
            found[name] = evidence.module("benchmarks", name).measured()
            step()
    if asked.json:
        listed = {n: [asdict(r) | {"ratio": r.ratio} for r in rows] for n, rows in found.items()}
        print(json.dumps(listed))
        return 0
    for name, rows in found.items():
        table = Table(*COLUMNS, title=name)
        for row in rows:
            table.add_row(*cells(row))
        Console().print(table)
    return 0


def cells(row: Row) -> tuple[str, ...]:
    """The cells of a row, below `COLUMNS`."""
    compared = ("", "") if row.theirs is None else (engineering(row.theirs), f"{row.ratio:.3g}")
    return row.name, engineering(row.ours), row.peer or "", *compared


def engineering(seconds: float) -> str:
    """Seconds with a prefix: 12.3 ms."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


if __name__ == "__main__":
    sys.exit(main())
