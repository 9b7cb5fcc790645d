"""Engines that run independent tasks: processes of this machine, or a Ray cluster."""

import os
import pickle
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from functools import partial
from itertools import islice
from typing import Any, Protocol, TypeVar

from loky import ProcessPoolExecutor
from loky.process_executor import BrokenProcessPool

from armside.sim.robot.run import cores

from ..shell.errors import InputError, RunFailed, needs, one_line
from ..shell.interrupts import noticing

Item = TypeVar("Item")

RETRIES = 3
"""Of a task whose node of a cluster went away."""
TIMEOUT = 10.0
"""[s], for a cluster to accept a connection."""
LOOK = 1.0
"""[s], between two looks of a worker whether its parent still lives."""


class Engine(Protocol):
    """Runs tasks, some at a time."""

    def results(
        self, function: Callable[[Item], Any], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Any]]:
        """Each item as it is done, with function(item) or the exception that was raised.

        Items are taken when they can start: until then, another process may have them.
        """
        ...

    def close(self) -> None:
        """Stop; what is under way is dropped."""


class WorkerDied(RunFailed):
    """The process that ran a task was killed, alone and for the second time."""

    def __init__(self) -> None:
        super().__init__("a worker process was killed (out of memory?)")


class Workers:
    """The engine of this machine: processes that the first task starts and `close` stops."""

    def __init__(self, count: int | None = None) -> None:
        """count: number of processes, all cores if None."""
        self.count = cores() if count is None else count
        if self.count < 1:
            raise ValueError(f"workers must be >= 1, got {self.count}")
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def results(
        self, function: Callable[[Item], Any], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Any]]:
        """See `Engine`. Which task has killed a process is not known: those that were under way
        are run again at the end, one at a time, and one that is killed again is `WorkerDied`."""
        suspects, running = list[Item](), dict[Future[Any], Item]()

        def outcomes(count: int, waiting: Iterator[Item]) -> Iterator[tuple[Item, Any]]:
            while _fill(running, count, waiting, partial(self._submit, function)):
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    item = running.pop(future)
                    try:
                        outcome = future.result()
                    except Exception as error:
                        outcome = error
                    yield item, outcome

        try:
            for item, outcome in outcomes(self.count, iter(items)):
                if isinstance(outcome, BrokenProcessPool):
                    suspects.append(item)
                else:
                    yield item, outcome
            for item, outcome in outcomes(1, iter(suspects)):
                yield item, WorkerDied() if isinstance(outcome, BrokenProcessPool) else outcome
        finally:
            if running:
                self.close()

    def close(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            with noticing(lambda: ""):
                pool.shutdown(kill_workers=True)

    def _submit(self, function: Callable[[Item], Any], item: Item) -> Future[Any]:
        begin = partial(ProcessPoolExecutor, self.count, initializer=_begin_worker)
        with noticing(lambda: ""):  # a pool that is half started could not be stopped
            for _ in range(2):
                self._pool = self._pool or begin(initargs=(os.getpid(),))
                with suppress(BrokenProcessPool):
                    return self._pool.submit(_run, function, item)
                self.close()
        raise WorkerDied


def _run(function: Callable[[Item], Any], item: Item) -> Any:
    """Its result, or its exception; as RunFailed where that is one that cannot be sent, which would
    break the pool as the death of a worker does."""
    try:
        return function(item)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            raise RunFailed(f"{type(error).__name__}: {error}") from None
        raise


class RayCluster:
    """The engine of a cluster whose nodes have armside installed. Tasks of lost nodes are run
    again."""

    def __init__(self, address: str) -> None:
        """Raises InputError when Ray is not installed or the cluster does not answer."""
        with needs("cluster", "the engine ray", "Ray"):
            import ray  # pyright: ignore[reportMissingImports]
        self._ray = ray
        try:
            _knock(address)
            ray.init(address=address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, RuntimeError, ValueError, OSError) as error:
            raise InputError(f"no Ray cluster answers at {address}: {one_line(error)}") from error
        self._call = ray.remote(num_cpus=1, max_retries=RETRIES)(_call)

    def results(
        self, function: Callable[[Item], Any], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Any]]:
        """See `Engine`."""
        waiting, running = iter(items), dict[Any, Item]()
        while _fill(running, self._size(), waiting, partial(self._call.remote, function)):
            for reference in self._ray.wait(list(running), num_returns=1)[0]:
                try:
                    outcome = self._ray.get(reference)
                except self._ray.exceptions.RayError as error:
                    outcome = error
                yield running.pop(reference), outcome

    def close(self) -> None:
        self._ray.shutdown()

    def _size(self) -> int:
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))


def _fill(
    running: dict[Any, Item], room: int, waiting: Iterator[Item], submit: Callable[[Item], Any]
) -> bool:
    """Start what can start, no more than `room` at a time; whether anything is under way."""
    for item in islice(waiting, max(0, room - len(running))):
        running[submit(item)] = item
    return bool(running)


def _call(function: Callable[[Any], Any], item: Any) -> Any:
    return function(item)


def _knock(address: str) -> None:
    """Raise OSError when nobody listens at host:port; Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host, int(port)), TIMEOUT).close()


def _begin_worker(parent: int) -> None:
    """Ctrl-C reaches every process of a terminal, and the parent decides what ends; where the
    parent is killed, its workers would wait for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
