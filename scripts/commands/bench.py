"""`armside bench [NAME]`: how long things take here, beside other libraries if installed.

A benchmark is a function `() -> Sequence[Row]` (`benchmarks.timing`) and one line in
BENCHMARKS.
"""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated

from cyclopts import Parameter

from armside.sim.records.summary import summary

from ..benchmarks.timing import Row
from ..shell.console import Report, keep
from ..shell.options import Common
from ..shell.registry import load, unknown

BENCHMARKS = {
    "ilc": "armside.scripts.benchmarks.ilc:ilc",
    "imu": "armside.scripts.benchmarks.imu:imu",
    "kinematics": "armside.scripts.benchmarks.kinematics:kinematics",
    "robot": "armside.scripts.benchmarks.robot:robot",
    "estimation": "armside.scripts.benchmarks.estimation:estimation",
    "env": "armside.scripts.benchmarks.env:env",
    "sweep": "armside.scripts.benchmarks.sweep:sweep",
    "scaling": "armside.scripts.benchmarks.robot:scaling",
}
"""Name: module:function. A new benchmark is one line here."""

COLUMNS = ("", "ours", "peer", "theirs", "ours / theirs")


Name = Annotated[str, Parameter(help=f"Which benchmark: {', '.join(BENCHMARKS)}, or all.")]


def bench(name: Name = "all", /, *, common: Common = Common()) -> None:
    """Time this machine: medians in seconds, and ratios to other libraries taken in turns."""
    if name not in ("all", *BENCHMARKS):
        raise unknown("benchmark", name, BENCHMARKS)
    names = list(BENCHMARKS) if name == "all" else [name]
    report = Report(common)
    results: dict[str, Sequence[Row]] = {}
    with report.progress("measuring", total=len(names)) as step:
        for key in names:
            results[key] = load(BENCHMARKS[key])()
            step()
    for key, rows in results.items():
        report.table(key, COLUMNS, [_cells(row) for row in rows])
    listed = {
        key: [asdict(row) | {"ratio": row.ratio} for row in rows] for key, rows in results.items()
    }
    outcome = summary("bench", {"name": name}, common, benchmarks=listed)
    keep(outcome, common)
    report.summary(outcome)


def _cells(row: Row) -> tuple[str, str, str, str, str]:
    theirs = "" if row.theirs is None else engineering(row.theirs)
    ratio = "" if row.ratio is None else f"{row.ratio:.3g}"
    return row.name, engineering(row.ours), row.peer or "", theirs, ratio


def engineering(seconds: float) -> str:
    """Seconds with a prefix: 12.3 ms."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"
