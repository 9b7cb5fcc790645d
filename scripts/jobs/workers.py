"""Independent work on several processes: results in the order of the items, whatever the number."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

from armside.sim.cores import cores

Item = TypeVar("Item")
Result = TypeVar("Result")


class Workers:
    """Worker processes, started at the first call and stopped at the end of the block."""

    def __init__(self, count: int | None = None) -> None:
        """count: number of processes, all cores if None."""
        self.count = cores() if count is None else count
        if self.count < 1:
            raise ValueError(f"workers must be >= 1, got {self.count}")

    def __enter__(self) -> "Workers":
        # Forked threads are unsafe: workers are started afresh.
        context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
        self._pool = ProcessPoolExecutor(self.count, mp_context=context, initializer=begin_worker)
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of each item, in order; an exception of any is raised here."""
        return list(self.stream(function, items))

    def stream(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        """As `map`, each result as soon as it and all before it are there."""
        return self._pool.map(function, items)

    def unordered(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Result | Exception]]:
        """Each item with function(item) or what it raised, as soon as it is there.

        A worker that dies makes `BrokenProcessPool` the outcome of all items without one.
        """
        futures = {self._pool.submit(function, item): item for item in items}
        for future in as_completed(futures):
            error = future.exception()
            if error is not None and not isinstance(error, Exception):
                raise error
            yield futures.pop(future), future.result() if error is None else error


def begin_worker() -> None:
    """Ctrl-C reaches every process of a terminal, and the parent decides what ends; where the
    parent is killed, its workers would wait for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
