"""The claims of `armside verify sweep` and `sweep-memory`: killed sweeps resume, memory is flat."""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

from armside.sim.evaluation.check import Table, all_hold

from ..jobs.dataset import Dataset
from ..jobs.grid import Grid, parse, run_grid
from ..jobs.queue import KNOWN, KNOWN_FAILED
from ..jobs.workers import Workers
from ..shell.errors import RunFailed

PLACES = "position=1316.6/1.4/1599.2,1800/100/1599.2,9000/0/1000"
AXES = ("gamma=0.5,0.7,0.9", "delta=3,6", PLACES, "seed=0:2")
"""Two thirds can be done; the third place is out of reach."""
LOOK = 0.01  # [s], between two looks at what is on disk
SAMPLES = 10
FLAT = 1.10  # of the memory after a tenth of the work


def sweep(seeds: Iterable[int]) -> Table:
    """One sweep per seed is killed (SIGKILL) at a random moment of its work and run again.

    Raises RunFailed for a sweep that ends without a result.
    """
    grid = parse(AXES, 0)
    with tempfile.TemporaryDirectory() as folder:
        process = _begun(Path(folder) / "whole")
        start = time.perf_counter()
        process.wait()
        duration = time.perf_counter() - start
        whole = Dataset(Path(folder) / "whole").read()
        rows = []
        for seed in seeds:
            killed = Path(folder) / str(seed)
            delay = random.Random(seed).uniform(0.0, duration)
            kept = _kill(killed, delay)
            with Workers() as workers:
                counts = run_grid(grid, Dataset(killed), workers)
            known = counts[KNOWN] + counts[KNOWN_FAILED]
            now = counts.total() - known
            rows.append((seed, delay, kept, known, now, Dataset(killed).read().equals(whole)))
    n, found = len(grid), all(row[2] == row[3] for row in rows)
    return Table(
        "Sweeps killed at random moments and run again",
        (
            *("seed", "killed after its first result [s]", "results on disk then", "taken over"),
            *("computed", "dataset equal to an undisturbed one"),
        ),
        rows,
        (
            all_hold(f"an undisturbed sweep holds all {n} configurations", len(whole) == n),
            all_hold("no result on disk is lost or computed again", found),
            all_hold("the rest is computed once", all(r[3] + r[4] == n for r in rows)),
            all_hold("the dataset equals that of an undisturbed sweep", all(r[5] for r in rows)),
        ),
    )


def memory(seeds: Iterable[int]) -> Table:
    """A sweep over as many short configurations as seeds: memory of the sweep and its workers."""
    seeds = list(seeds)
    grid = Grid({"iterations": (0,), "speed": (60.0,), "seed": seeds})
    rows: list[tuple[int, float, float]] = []
    n = 0
    every = max(1, len(seeds) // SAMPLES)

    def step() -> None:
        nonlocal n
        n += 1
        if n % every == 0:
            workers = [_resident(pid) for pid in _descendants(os.getpid())]
            rows.append((n, _resident(os.getpid()), max(workers, default=0.0)))

    with tempfile.TemporaryDirectory() as folder, Workers() as ours:
        counts = run_grid(grid, Dataset(Path(folder)), ours, step)
    pairs = zip(rows[0][1:], rows[-1][1:], strict=True)
    flat = f"memory after all is at most {FLAT} times that after the first tenth"
    return Table(
        "Memory of a sweep over many configurations",
        ("configurations done", "the sweep [MiB]", "its largest worker [MiB]"),
        rows,
        (
            all_hold(f"all {len(seeds)} configurations are done", counts["done"] == len(seeds)),
            all_hold(flat, [end <= FLAT * start for start, end in pairs]),
        ),
    )


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


def _begun(folder: Path) -> subprocess.Popen[bytes]:
    """A sweep with its first result on disk: it takes longer to start than to do its work."""
    command = [sys.executable, "-m", "armside.scripts.cli", "sweep", *AXES, "--into", str(folder)]
    here, silent = Path(__file__).parents[2], subprocess.DEVNULL
    # It says at its end that some configurations have failed, which they should.
    process = subprocess.Popen([*command, "--quiet"], cwd=here, stderr=silent)
    while not Dataset(folder).keys():
        if process.poll() is not None:
            raise RunFailed("the sweep ended without a result")
        time.sleep(LOOK)
    return process


def _kill(folder: Path, delay: float) -> int:
    """Start a sweep, kill it some time after its first result, and count what is on disk."""
    process = _begun(folder)
    try:
        process.wait(delay)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
    return len(Dataset(folder).keys())
