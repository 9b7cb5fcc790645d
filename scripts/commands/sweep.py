"""`armside sweep`: a grid over the options of `armside laser`, into one Parquet dataset."""

import hashlib
import sys
from contextlib import closing
from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Parameter

from armside.sim.records.run_folder import RUNS
from armside.sim.records.summary import summary

from ..jobs.dataset import Dataset, first_error, noted
from ..jobs.grid import parse, run_grid
from ..jobs.queue import FAILED, KNOWN_FAILED
from ..jobs.workers import RayCluster, Workers
from ..shell.console import Report
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common, Count, Folder, options

OF_A_WORKER = Effort(bytes=0.2e9)


@options
@dataclass(frozen=True, kw_only=True)
class SweepCfg:
    """Where results go and where they are computed."""

    into: Folder | None = None
    """Folder of the dataset; what it holds is not computed again [default: runs/sweep- and a hash
    of the grid]."""
    engine: Literal["local", "ray"] = "local"
    """Processes of this machine, or a Ray cluster."""
    address: str | None = None
    """Address of the Ray cluster, such as 10.0.0.1:6379."""
    workers: Count | None = None
    """Processes of the local engine [default: one for each core]."""
    retry_failed: bool = False
    """Run configurations again that have failed before."""

    def __post_init__(self) -> None:
        if self.workers is not None:
            refuse_absurd(f"{self.workers} workers", OF_A_WORKER * self.workers)
        if self.engine == "ray" and self.address is None:
            raise ValueError("engine ray needs --address, the one that `ray start --head` printed")
        if self.engine == "local" and self.address is not None:
            raise ValueError("--address is of the engine ray; the local engine has none")


Axes = Annotated[str, Parameter(help="Axes: option=value,value of armside laser, or seed=0:10.")]


def sweep(*axes: Axes, cfg: SweepCfg = SweepCfg(), common: Common = Common()) -> None:
    """Run a laser experiment for each point of a grid. Interrupted, it goes on where it was.

    Results are rows of a Parquet dataset, part-0.parquet, keyed by a hash of the configuration.
    Several sweeps may share a folder at the same time. A configuration that fails is a row too.

    Raises InputError for a grid or an engine that cannot be had, and RunFailed where a
    configuration has failed or a file of the folder is damaged.
    """
    report = Report(common)

    def waiting(n: int) -> None:
        if not common.quiet:
            said = f"armside: waiting for {n} configurations that another sweep has claimed"
            print(said, file=sys.stderr, flush=True)

    with checking_input():
        engine = Workers(cfg.workers) if cfg.engine == "local" else RayCluster(str(cfg.address))
    with closing(engine):
        with checking_input():
            grid = parse(axes, common.seed)
            points = list(grid)
        keys = [point.key for point in points]
        name = hashlib.sha256("".join(sorted(keys)).encode()).hexdigest()[:8]
        rows = Dataset(cfg.into or RUNS / f"sweep-{name}")
        try:
            with report.progress("sweeping", total=len(points)) as step:
                counts = run_grid(
                    points, rows, engine, step, retry_failed=cfg.retry_failed, waiting=waiting
                )
        except KeyboardInterrupt:
            kept = len(rows.keys() & set(keys))
            said = f"interrupted; {kept} of {len(keys)} configurations are kept in {rows.folder}"
            again = f"{said}, repeat the command to go on"
            raise KeyboardInterrupt(again if kept else "") from None
    # None too where another sweep has meanwhile run all that failed again.
    n_failed = counts[FAILED] + counts[KNOWN_FAILED]
    error = first_error(rows, keys) if n_failed else None
    asked = {"axes": list(axes), "into": rows.folder, "engine": cfg.engine}
    status, outcomes = "done" if error is None else "failed", dict(sorted(counts.items()))
    n_noted, note = noted(rows, set(keys))
    found = {"configurations": len(points), "outcomes": outcomes}
    found["notes"] = [{"text": note, "configurations": n_noted}] if n_noted else []
    outcome = summary("sweep", asked, common, status=status, **found)
    report.keep(outcome)
    if len(points) < len(grid):
        report.line(f"{len(grid)} combinations, of which {len(points)} are different")
    counted = ", ".join(f"{n} {status}" for status, n in outcomes.items())
    report.line(f"{len(points)} configurations: {counted}")
    if n_noted:
        report.line(f"Note: limits changed {n_noted} of them (column notes), mostly: {note}")
    report.line(f"Results in {rows.folder}/part-0.parquet")
    report.summary(outcome)
    if error is not None:
        raise RunFailed(
            f"{n_failed} of {len(points)} configurations failed, the first with {error} "
            "(--retry-failed runs them again)"
        )
