"""Benchmark of the sweep: what it costs beyond the experiments it runs."""

import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from statistics import median

from ..commands import laser
from ..commands.sweep import run_grid
from ..jobs.dataset import Store
from ..jobs.engine import Local
from ..jobs.grid import Grid
from ..jobs.workers import cores
from .timing import Row

N = 24


def sweep() -> Sequence[Row]:
    """Laser experiments through a sweep, against the same ones in a bare process pool.

    Both start their processes anew in each round: that is part of a sweep.
    """
    with tempfile.TemporaryDirectory() as folder:
        rounds = [(_swept(Path(folder) / str(n), n), _bare(n)) for n in range(5)]
    ours, theirs = (median(column) for column in zip(*rounds, strict=True))
    return [Row(f"sweep of {N} experiments", ours, "bare process pool", theirs)]


def _swept(folder: Path, n: int) -> float:
    grid = Grid({"seed": range(n * N, (n + 1) * N)})
    start = time.perf_counter()
    run_grid(grid, Store(folder), Local())
    return time.perf_counter() - start


def _bare(n: int) -> float:
    start = time.perf_counter()
    with ProcessPoolExecutor(cores(), mp_context=get_context("forkserver")) as pool:
        list(pool.map(_experiment, range(n * N, (n + 1) * N)))
    return time.perf_counter() - start


def _experiment(seed: int) -> float:
    return laser.run(laser.LaserCfg(), seed)["iterations"][-1]["arm_rms"]
