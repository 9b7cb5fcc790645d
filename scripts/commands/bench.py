"""`armside bench [NAME]`: execution times on this machine, beside other libraries if installed.

A benchmark is a function `() -> Sequence[Row]` (`benchmarks.timing`).
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Annotated, Any

from cyclopts import Parameter

from armside.sim.records.summary import summary

from ..benchmarks.timing import Row
from ..shell.console import Report, keep
from ..shell.errors import unknown
from ..shell.options import Common

BENCHMARKS = (
    *("ilc", "imu", "kinematics", "robot", "scaling", "estimation", "env", "sweep", "start"),
    *("commission", "parts", "controller", "calibration"),
)
"""A new benchmark is a name here and two lines in `load`."""

COLUMNS = ("", "ours", "peer", "theirs", "ours / theirs")

Name = Annotated[str, Parameter(help=f"Benchmark: {', '.join(BENCHMARKS)}, or all.")]


def load(name: str) -> Callable[[], Sequence[Row]]:
    """The function of a benchmark. Only its module is imported."""
    match name:
        case "ilc":
            from ..benchmarks.ilc import ilc as benchmark
        case "imu":
            from ..benchmarks.imu import imu as benchmark
        case "kinematics":
            from ..benchmarks.kinematics import kinematics as benchmark
        case "robot":
            from ..benchmarks.robot import robot as benchmark
        case "scaling":
            from ..benchmarks.robot import scaling as benchmark
        case "estimation":
            from ..benchmarks.estimation import estimation as benchmark
        case "env":
            from ..benchmarks.env import env as benchmark
        case "sweep":
            from ..benchmarks.sweep import sweep as benchmark
        case "start":
            from ..benchmarks.start import start as benchmark
        case "commission":
            from ..benchmarks.commission import commission as benchmark
        case "parts":
            from ..benchmarks.parts import parts as benchmark
        case "controller":
            from ..benchmarks.controller import controller as benchmark
        case "calibration":
            from ..benchmarks.calibration import calibration as benchmark
        case _:
            raise unknown("benchmark", name, BENCHMARKS)
    return benchmark


def bench(name: Name = "all", /, *, common: Common = Common()) -> None:
    """Time this machine: medians in seconds, and ratios to other libraries taken in turns."""
    benchmarks = {key: load(key) for key in (BENCHMARKS if name == "all" else [name])}
    report = Report(common)
    results, listed = dict[str, Sequence[Row]](), dict[str, Any]()
    with report.progress("measuring", total=len(benchmarks)) as step:
        for key, benchmark in benchmarks.items():
            results[key] = benchmark()
            step()
    for key, rows in results.items():
        report.table(key, COLUMNS, [_cells(row) for row in rows])
        listed[key] = [asdict(row) | {"ratio": row.ratio} for row in rows]
    outcome = summary("bench", {"name": name}, common, benchmarks=listed)
    keep(outcome, common)
    report.summary(outcome)


def _cells(row: Row) -> tuple[str, ...]:
    compared = ("", "") if row.theirs is None else (engineering(row.theirs), f"{row.ratio:.3g}")
    return row.name, engineering(row.ours), row.peer or "", *compared


def engineering(seconds: float) -> str:
    """Seconds with a prefix: 12.3 ms."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"
