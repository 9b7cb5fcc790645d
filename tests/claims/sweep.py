"""Killed sweeps go on, and sweeps of any length keep to their memory.

Each seed kills a sweep (SIGKILL) at a random moment and runs it again; `sweep-memory` runs as many
short configurations as seeds.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Grid, parse, run_grid
from armside.scripts.jobs.queue import KNOWN, KNOWN_FAILED
from armside.scripts.jobs.workers import Workers

from ._engine import ROOT, Check, Claim, Row, Rows, Tally, all_hold, at_once

PLACES = "position=1316.6/1.4/1599.2,1800/100/1599.2,9000/0/1000"
AXES = ("gamma=0.5,0.7,0.9", "delta=3,6", PLACES, "seed=0:2")
"""Two thirds can be done; the third place is out of reach."""
LOOK = 0.01  # [s], between two looks at what is on disk
COLUMNS = {
    "seed": "seed",
    "delay": "killed after its first result [s]",
    "on_disk": "results on disk then",
    "known": "taken over",
    "computed": "computed",
    "equal": "dataset equal to an undisturbed one",
}


def run(seeds: tuple[int, ...], _: Tally) -> Iterator[Row]:
    grid = parse(AXES, 0)
    with tempfile.TemporaryDirectory() as folder:
        process = _begun(Path(folder) / "whole")
        start = time.perf_counter()
        process.wait()
        duration = time.perf_counter() - start
        whole = Dataset(Path(folder) / "whole").read()
        for seed in seeds:
            killed = Path(folder) / str(seed)
            delay = random.Random(seed).uniform(0.0, duration)
            on_disk = _kill(killed, delay)
            with Workers() as workers:
                counts = run_grid(grid, Dataset(killed), workers)
            known = counts[KNOWN] + counts[KNOWN_FAILED]
            yield {
                **{"seed": seed, "delay": delay, "on_disk": on_disk, "known": known},
                "computed": counts.total() - known,
                "equal": Dataset(killed).read().equals(whole),
                "_whole": len(whole),
            }


def checks(rows: Rows) -> Iterator[Check]:
    n = len(parse(AXES, 0))
    whole = rows["_whole"] == n
    yield all_hold(f"an undisturbed sweep holds all {n} configurations", whole)
    known = rows["on_disk"] == rows["known"]
    yield all_hold("no result on disk is lost or computed again", known)
    yield all_hold("the rest is computed once", rows["known"] + rows["computed"] == n)
    yield all_hold("the dataset equals that of an undisturbed sweep", rows["equal"])


def _begun(folder: Path) -> subprocess.Popen[bytes]:
    """A sweep with its first result on disk: it takes longer to start than to do its work."""
    command = [sys.executable, "-m", "armside", "sweep", *AXES, "--into", str(folder), "--quiet"]
    # At its end it reports on stderr that some configurations have failed, which they should.
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)
    while not Dataset(folder).keys():
        if process.poll() is not None:
            raise RuntimeError("the sweep ended without a result")
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


CLAIM = Claim(
    title="Sweeps killed at random moments and run again",
    seeds=10,
    cases=at_once,
    run=run,
    checks=checks,
    columns=COLUMNS,
    processes=1,
)


SAMPLES = 10
FLAT = 1.10  # of the memory after a tenth of the work
MEMORY = ("the sweep [MiB]", "its largest worker [MiB]")


def run_memory(seeds: tuple[int, ...], _: Tally) -> Iterator[Row]:
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


def checks_memory(rows: Rows) -> Iterator[Check]:
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


CLAIM_MEMORY = Claim(
    title="Memory of a sweep over many configurations",
    seeds=10_000,
    cases=at_once,
    run=run_memory,
    checks=checks_memory,
    processes=1,
)
