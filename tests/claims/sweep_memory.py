"""Memory of a sweep and its workers, over as many short configurations as seeds."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Grid, run_grid
from armside.scripts.jobs.workers import Workers

from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_once

SAMPLES = 10
FLAT = 1.10  # of the memory after a tenth of the work
MEMORY = ("the sweep [MiB]", "its largest worker [MiB]")


def run(seeds: tuple[int, ...], _: Tally) -> Iterator[Row]:
    grid = Grid({"iterations": (0,), "speed": (60.0,), "seed": list(seeds)})
    rows, n = list[Row](), 0
    every = max(1, len(seeds) // SAMPLES)

    def step() -> None:
        nonlocal n
        n += 1
        if n % every == 0:
            workers = [_resident(pid) for pid in _descendants(os.getpid())]
            memory = (_resident(os.getpid()), max(workers, default=0.0))
            rows.append({"configurations done": n} | dict(zip(MEMORY, memory, strict=True)))

    with tempfile.TemporaryDirectory() as folder, Workers() as ours:
        counts = run_grid(grid, Dataset(Path(folder)), ours, step)
    yield from ({**row, "_done": counts["done"], "_asked": len(seeds)} for row in rows)


def checks(rows: Rows) -> Iterator[Check]:
    last, memory = rows.rows[-1], rows.of(*MEMORY)
    done = last["_done"] == last["_asked"]
    yield all_hold(f"all {last['_asked']} configurations are done", done)
    flat = f"memory after all is at most {FLAT} times that after the first tenth"
    yield all_hold(flat, memory[-1] <= FLAT * memory[0])


def _resident(pid: int) -> float:
    """Resident memory [MiB] of a process, 0 if it has gone."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def _descendants(pid: int) -> list[int]:
    """Children of a process, and theirs."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, task.read_text().split()):
            found += [child, *_descendants(child)]
    return found


CLAIM = Claim(
    title="Memory of a sweep over many configurations",
    seeds=10_000,
    cases=at_once,
    run=run,
    checks=checks,
    processes=1,
)
