"""Killed sweeps go on: each seed kills a sweep (SIGKILL) at a random moment and runs it again."""

import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import parse, run_grid
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
