"""`armside sweep`: a grid over the options of `armside laser`, into one Parquet dataset."""

import hashlib
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from armside.sim.records.run_folder import RUNS
from armside.sim.records.summary import summary

from ..jobs.dataset import FAILED, Block, Row, Store, block_of, failures, keys_kept
from ..jobs.engine import Engine, Local, OnRay
from ..jobs.grid import Point, parse
from ..shell.console import Report, keep
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common, options

POLL = 0.2
"""[s], between two looks at blocks that another sweep holds."""
KNOWN, KNOWN_FAILED = "known", "known (failed)"
"""Outcomes of configurations that were there before."""


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

    Raises InputError for a grid or an engine that cannot be had, and RunFailed where a
    configuration has failed or the folder has no locks.
    """
    report = Report(common)
    with checking_input():
        engine = Local(cfg.workers) if cfg.engine == "local" else OnRay(str(cfg.address))
    with closing(engine):
        with checking_input():
            grid = parse(axes, common.seed)
            points = list(grid)
        folder = cfg.into or RUNS / f"sweep-{_name(points)}"
        try:
            with report.progress("sweeping", total=len(points)) as step:
                counts = run_grid(
                    points,
                    Store(folder),
                    engine,
                    step,
                    retry_failed=cfg.retry_failed,
                    waiting=(lambda n: None) if common.quiet else _say_waiting,
                )
        except KeyboardInterrupt:
            raise KeyboardInterrupt(_interrupted(points, folder)) from None
    error = _first_error(points, folder) if counts[FAILED] + counts[KNOWN_FAILED] else None
    outcome = summary(
        "sweep",
        {"axes": list(axes), "into": folder, "engine": cfg.engine},
        common,
        status="done" if error is None else "failed",
        configurations=len(points),
        outcomes=dict(sorted(counts.items())),
    )
    keep(outcome, common)
    if len(points) < len(grid):
        report.line(f"{len(grid)} combinations, of which {len(points)} are different")
    said = ", ".join(f"{n} {status}" for status, n in sorted(counts.items()))
    report.line(f"{len(points)} configurations: {said}")
    report.line(f"Results in {folder}/part-*.parquet")
    report.summary(outcome)
    if error is not None:
        n = counts[FAILED] + counts[KNOWN_FAILED]
        raise RunFailed(
            f"{n} of {len(points)} configurations failed, the first with {error} "
            "(--retry-failed runs them again)"
        )


def run_grid(
    points: Iterable[Point],
    store: Store,
    engine: Engine,
    step: Callable[[], None] = lambda: None,
    *,
    retry_failed: bool = False,
    waiting: Callable[[int], None] = lambda n: None,
) -> Counter[str]:
    """Bring a store up to all points of a grid; close the engine.

    Args:
        step: called for each point that has a result.
        waiting: called once nothing is left to do but to wait for others, with the number of
            points that they have claimed.

    Returns:
        How many points ended as done, diverged or failed now, and were there before: "known", or
        "known (failed)".

    Raises:
        RunFailed: the store's file system has no locks.
        OSError: the store cannot be written to.
        pyarrow.ArrowInvalid: a part of the store is damaged.
    """
    return _Sweep(points, store, engine, step, retry_failed).run(waiting)


class _Sweep:
    """Blocks of a grid on their way through the store and the engine."""

    def __init__(
        self,
        points: Iterable[Point],
        store: Store,
        engine: Engine,
        step: Callable[[], None],
        retry_failed: bool,
    ) -> None:
        self._store, self._engine, self._step = store, engine, step
        self._retry_failed = retry_failed
        self._points: dict[str, dict[str, Point]] = {}
        """By block and key."""
        for point in points:
            self._points.setdefault(block_of(point.key), {})[point.key] = point
        self._unclaimed = deque(sorted(self._points))
        self._held_elsewhere = deque[str]()
        self._ready = deque[Point]()
        self._ours: dict[str, Block] = {}
        self._left: Counter[str] = Counter()
        self._counts: Counter[str] = Counter()

    def run(self, waiting: Callable[[int], None]) -> Counter[str]:
        """All of it, as `run_grid`."""
        told = False
        try:
            while self._unclaimed or self._held_elsewhere or self._ready or self._engine.busy:
                self._fill()
                # Only now: writing a part takes time in which workers would have nothing to do.
                self._close_finished()
                if self._engine.busy:
                    for row in self._engine.collect():
                        self._keep(row)
                elif self._held_elsewhere:
                    if not told:
                        waiting(sum(len(self._points[name]) for name in self._held_elsewhere))
                        told = True
                    time.sleep(POLL)
                if not (self._unclaimed or self._ready):
                    self._unclaimed, self._held_elsewhere = self._held_elsewhere, deque()
        finally:
            self._engine.close()
            for block in self._ours.values():
                block.close()
        return self._counts

    def _fill(self) -> None:
        """Give the engine what it can start now. A block is claimed when its turn has come: until
        then another sweep may have it."""
        while self._engine.room > 0 and (self._ready or self._unclaimed):
            if self._ready:
                self._engine.submit(self._ready.popleft())
            else:
                self._claim(self._unclaimed.popleft())

    def _claim(self, name: str) -> None:
        block = self._store.claim(name, retry_failed=self._retry_failed)
        if block is None:
            self._held_elsewhere.append(name)
            return
        self._ours[name] = block
        for key, point in self._points[name].items():
            if key in block.done:
                self._count(KNOWN_FAILED if key in block.failed else KNOWN)
            else:
                self._ready.append(point)
                self._left[name] += 1
        if not self._left[name]:
            self._ours.pop(name).close()

    def _keep(self, row: Row) -> None:
        name = block_of(row["key"])
        self._ours[name].add(row)
        self._left[name] -= 1
        self._count(row["status"])

    def _count(self, status: str) -> None:
        self._counts[status] += 1
        self._step()

    def _close_finished(self) -> None:
        for name in [name for name in self._ours if not self._left[name]]:
            self._ours.pop(name).close()


def _say_waiting(n: int) -> None:
    said = f"waiting for {n} configurations that another sweep has claimed"
    print(f"armside: {said}", file=sys.stderr, flush=True)


def _interrupted(points: Sequence[Point], folder: Path) -> str:
    """What is left of a sweep that was stopped; empty if nothing is."""
    kept = len(keys_kept(folder) & {point.key for point in points})
    if not kept:
        return ""
    return (
        f"interrupted; {kept} of {len(points)} configurations are kept in {folder}, "
        "repeat the command to go on"
    )


def _first_error(points: Iterable[Point], folder: Path) -> str | None:
    """Of the first point, in the order of the grid, that has failed; None if another sweep has
    meanwhile run all of them again."""
    known = failures(folder)
    return next((known[point.key] for point in points if point.key in known), None)


def _name(points: Iterable[Point]) -> str:
    keys = hashlib.sha256("".join(sorted(point.key for point in points)).encode())
    return keys.hexdigest()[:8]
