"""`armside sweep`: a grid over the options of `armside laser`, into one Parquet dataset."""

import hashlib
import time
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from .console import Report
from .errors import checking_input
from .options import Common, options
from .run_folder import RUNS
from .summary import keep, summary
from .sweep_engine import Engine, Local, OnRay
from .sweep_grid import Grid, Point, parse
from .sweep_store import Block, Store, block_of

POLL = 0.2
"""[s], between two looks at blocks that another sweep holds."""


@options
@dataclass(frozen=True, kw_only=True)
class SweepCfg:
    """Where results go and where they are computed."""

    into: Path | None = None
    """Folder of the dataset; what it holds is not computed again [default: runs/sweep- and a hash
    of the grid]."""
    engine: Literal["local", "ray"] = "local"
    """Processes of this machine, or a Ray cluster."""
    address: str | None = None
    """Address of the Ray cluster, such as 10.0.0.1:6379."""
    workers: int | None = None
    """Processes of the local engine [default: one for each core]."""
    retry_failed: bool = False
    """Run configurations again that have failed before."""

    def __post_init__(self) -> None:
        if self.workers is not None and self.workers < 1:
            raise ValueError(f"workers must be >= 1, got {self.workers}")
        if self.engine == "ray" and self.address is None:
            raise ValueError("engine ray needs --address, the one that `ray start --head` printed")
        if self.engine == "local" and self.address is not None:
            raise ValueError("--address is of the engine ray; the local engine has none")
        if self.into is not None and self.into.exists() and not self.into.is_dir():
            raise ValueError(f"{self.into} is a file; give a folder")


Axes = Annotated[str, Parameter(help="Axes: option=value,value of armside laser, or seed=0:10.")]


def sweep(*axes: Axes, cfg: SweepCfg = SweepCfg(), common: Common = Common()) -> None:
    """Run a laser experiment for each point of a grid. Interrupted, it goes on where it was.

    Results are rows of a Parquet dataset, part-*.parquet, keyed by a hash of the configuration.
    Several sweeps may share a folder at the same time. A configuration that fails is a row too.
    """
    report = Report(common)
    with checking_input():
        grid = parse(axes, common.seed)
        folder = cfg.into or RUNS / f"sweep-{_name(grid)}"
        engine = Local(cfg.workers) if cfg.engine == "local" else OnRay(str(cfg.address))
    with report.progress("sweeping", total=len(grid)) as step:
        counts = run_grid(grid, Store(folder), engine, step, retry_failed=cfg.retry_failed)
    outcome = summary(
        "sweep",
        {"axes": list(axes), "into": folder, "engine": cfg.engine},
        common,
        configurations=len(grid),
        outcomes=dict(sorted(counts.items())),
    )
    keep(outcome, common)
    said = ", ".join(f"{n} {status}" for status, n in sorted(counts.items()))
    report.line(f"{len(grid)} configurations: {said}")
    report.line(f"Results in {folder}/part-*.parquet")
    report.summary(outcome)


def run_grid(
    grid: Grid,
    store: Store,
    engine: Engine,
    step: Callable[[], None] = lambda: None,
    *,
    retry_failed: bool = False,
) -> Counter[str]:
    """Bring a store up to all points of a grid; close the engine.

    Returns how many points ended as done, diverged or failed now, and were there before ("known").
    """
    blocks: dict[str, list[Point]] = {}
    for point in grid:
        blocks.setdefault(block_of(point.key), []).append(point)
    unclaimed, held_elsewhere = deque(sorted(blocks)), deque[str]()
    ready: deque[Point] = deque()
    ours: dict[str, Block] = {}
    left: Counter[str] = Counter()
    counts: Counter[str] = Counter()

    def claim(name: str) -> None:
        block = store.claim(name, retry_failed=retry_failed)
        if block is None:
            held_elsewhere.append(name)
            return
        ours[name] = block
        todo = [point for point in blocks[name] if point.key not in block.done]
        for _ in range(len(blocks[name]) - len(todo)):
            counts["known"] += 1
            step()
        ready.extend(todo)
        left[name] = len(todo)
        if not todo:
            ours.pop(name).close()

    try:
        while unclaimed or held_elsewhere or ready or engine.busy:
            while engine.room > 0 and (ready or unclaimed):
                if ready:
                    engine.submit(ready.popleft())
                else:
                    claim(unclaimed.popleft())
            if engine.busy:
                for row in engine.collect():
                    name = block_of(row["key"])
                    ours[name].add(row)
                    counts[row["status"]] += 1
                    step()
                    left[name] -= 1
                    if not left[name]:
                        ours.pop(name).close()
            if not (unclaimed or ready) and held_elsewhere:
                if not engine.busy:
                    time.sleep(POLL)
                unclaimed, held_elsewhere = held_elsewhere, deque[str]()
    finally:
        engine.close()
        for block in ours.values():
            block.close()
    return counts


def _name(grid: Grid) -> str:
    keys = hashlib.sha256("".join(sorted(point.key for point in grid)).encode())
    return keys.hexdigest()[:8]
