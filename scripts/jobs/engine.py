"""Where the points of a sweep are run: on the processes of this machine, or on a Ray cluster."""

import os
import socket
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from importlib.metadata import version
from multiprocessing import get_context
from typing import Any, Protocol

from armside.sim.records.summary import plain

from ..commands import laser
from ..shell.errors import InputError, one_line
from .dataset import FAILED, Row, measures
from .grid import Point, configuration
from .resolved import key_of, resolved
from .store import code_fingerprint
from .workers import begin_worker, cores

RETRIES = 3
"""Of a point whose node went away."""
ANSWER = 10.0
"""[s], for a cluster to accept a connection."""


def simulate(point: Point) -> Row:
    """Run one point. Whatever goes wrong with it becomes its result."""
    try:
        outcome = laser.run(configuration(point), point.seed)
        if key_of(point.options, point.seed) != point.key:
            return failed(point, "a file of its options is not what it was when the sweep began")
        return _row(point) | measures(outcome) | {"status": outcome["status"]}
    except Exception as error:
        return failed(point, f"{type(error).__name__}: {one_line(error)}")


def failed(point: Point, error: str) -> Row:
    """The row of a point that has no result."""
    return _row(point) | {"status": FAILED, "error": error}


def _row(point: Point) -> Row:
    try:
        options = resolved(configuration(point))
    except (ValueError, OSError):
        options = plain(point.options)
    by = {
        "version": version("armside"),
        "code": code_fingerprint("armside.scripts.commands.laser")[:12],
    }
    return {"key": point.key, "seed": point.seed, **options, **by}


class Engine(Protocol):
    """Runs points, some at a time, and returns their rows in any order."""

    @property
    def room(self) -> int:
        """Points that can start now. No more are taken on: they may be left to another sweep."""
        ...

    @property
    def busy(self) -> bool:
        """Points are under way."""
        ...

    def submit(self, point: Point) -> None:
        """Take on a point."""
        ...

    def collect(self) -> list[Row]:
        """Wait for points that are under way; at least one of them, or none while it recovers."""
        ...

    def close(self) -> None:
        """Stop; what is under way is given up."""
        ...


class Local:
    """Processes of this machine. One that dies takes only its own point with it."""

    def __init__(
        self, workers: int | None = None, *, function: Callable[[Point], Row] = simulate
    ) -> None:
        """workers: number of processes, all cores if None. function: what runs a point, raising
        nothing."""
        self._function = function
        self._workers = workers or cores()
        self._pool: ProcessPoolExecutor | None = None
        self._running: dict[Future[Row], Point] = {}
        self._suspects: deque[Point] = deque()

    @property
    def room(self) -> int:
        return 0 if self._suspects else self._workers - len(self._running)

    @property
    def busy(self) -> bool:
        return bool(self._running or self._suspects)

    def submit(self, point: Point) -> None:
        if self._pool is None:
            # Forked threads are unsafe: workers are started afresh.
            context = get_context("forkserver" if os.name == "posix" else "spawn")
            self._pool = ProcessPoolExecutor(
                self._workers, mp_context=context, initializer=begin_worker
            )
        try:
            self._running[self._pool.submit(self._function, point)] = point
        except BrokenProcessPool:
            self._suspects.append(point)
            self.close()

    def collect(self) -> list[Row]:
        """A worker that died breaks the pool, and nobody knows whose fault it was: all points that
        were under way are then run again, one at a time, until each has a result or is guilty."""
        alone = not self._running
        if alone:
            self.submit(self._suspects.popleft())
        done, _ = wait(self._running, return_when=FIRST_COMPLETED)
        rows, broken = [], False
        for future in done:
            point = self._running.pop(future)
            try:
                rows.append(future.result())
            except BrokenProcessPool:
                broken = True
                if alone:
                    rows.append(failed(point, "the worker process died"))
                else:
                    self._suspects.append(point)
        if broken:
            self._suspects.extend(self._running.values())
            self._running.clear()
            self.close()
        return rows

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None


class OnRay:
    """A Ray cluster whose nodes have armside installed. Lost nodes' points are run again."""

    def __init__(self, address: str) -> None:
        """Raises InputError when Ray is not installed or the cluster does not answer."""
        try:
            import ray  # pyright: ignore[reportMissingImports]
        except ImportError as error:
            raise InputError("the engine ray needs Ray: pip install 'armside[cluster]'") from error
        self._ray = ray
        try:
            _knock(address)
            ray.init(address=address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, RuntimeError, ValueError, OSError) as error:
            raise InputError(f"no Ray cluster answers at {address}: {one_line(error)}") from error
        self._simulate = ray.remote(num_cpus=1, max_retries=RETRIES)(simulate)
        self._running: dict[Any, Point] = {}

    @property
    def room(self) -> int:
        return max(1, int(self._ray.cluster_resources().get("CPU", 1))) - len(self._running)

    @property
    def busy(self) -> bool:
        return bool(self._running)

    def submit(self, point: Point) -> None:
        self._running[self._simulate.remote(point)] = point

    def collect(self) -> list[Row]:
        done, _ = self._ray.wait(list(self._running), num_returns=1)
        rows = []
        for reference in done:
            point = self._running.pop(reference)
            try:
                rows.append(self._ray.get(reference))
            except self._ray.exceptions.RayError as error:
                rows.append(failed(point, f"{type(error).__name__}: {one_line(error)}"))
        return rows

    def close(self) -> None:
        self._ray.shutdown()


def _knock(address: str) -> None:
    """Raise OSError when nobody listens at host:port; Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host, int(port)), ANSWER).close()
