"""Benchmark of the sweep: what it costs beyond the experiments it runs."""

import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from statistics import median

from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import Grid, parse, run_grid
from armside.scripts.jobs.workers import Workers
from armside.sim.robot.run import cores

from ._timing import Row
from .scaling import experiment

N = 24
N_LARGE = 2000


def measured() -> Sequence[Row]:
    """Laser experiments through a sweep, against the same ones in a bare process pool.

    Both start their processes anew in each round: that is part of a sweep.
    """
    with tempfile.TemporaryDirectory() as folder:
        rounds = [(_swept(Path(folder) / str(n), n), _bare(n)) for n in range(5)]
    ours, theirs = (median(column) for column in zip(*rounds, strict=True))
    return [
        Row(f"sweep of {N} experiments", ours, "bare process pool", theirs),
        Row(f"grid of {N_LARGE} configurations read", median(_read() for _ in range(5))),
    ]


def _read() -> float:
    gains = ",".join(f"{0.001 * i:.3f}" for i in range(1, N_LARGE + 1))
    start = time.perf_counter()
    list(parse((f"gamma={gains}",), 0))
    return time.perf_counter() - start


def _swept(folder: Path, n: int) -> float:
    grid = Grid({"seed": range(n * N, (n + 1) * N)})
    start = time.perf_counter()
    with Workers() as workers:
        run_grid(grid, Dataset(folder), workers)
    return time.perf_counter() - start


def _bare(n: int) -> float:
    start = time.perf_counter()
    with ProcessPoolExecutor(cores(), mp_context=get_context("forkserver")) as pool:
        list(pool.map(experiment, range(n * N, (n + 1) * N)))
    return time.perf_counter() - start
