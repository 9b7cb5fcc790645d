"""Independent work on the processes of this machine. One that dies takes only its own job along."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, NamedTuple, TypeVar

from armside.sim.robot.run import cores

from ..shell.errors import RunFailed
from ..shell.interrupts import noticing

Item = TypeVar("Item")
Result = TypeVar("Result")


class WorkerDied(RunFailed):
    """The process that ran a job was killed, alone and for the second time."""

    def __init__(self) -> None:
        super().__init__("a worker process was killed (out of memory?)")


class _Task(NamedTuple):
    tag: Hashable
    function: Callable[[Any], Any]
    item: Any


class Workers:
    """Worker processes, started by the first task and stopped at the end of the block.

    An engine of `queue.Queue`; `map` serves work that is not stored.
    """

    def __init__(self, count: int | None = None) -> None:
        """count: number of processes, all cores if None."""
        self.count = cores() if count is None else count
        if self.count < 1:
            raise ValueError(f"workers must be >= 1, got {self.count}")
        self._pool: ProcessPoolExecutor | None = None
        self._running: dict[Future[Any], _Task] = {}
        self._suspects: deque[_Task] = deque()
        """Under way when a process died, to be run again."""

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None and issubclass(kind, KeyboardInterrupt):
            _kill()  # outcomes of tasks in flight would be dropped after minutes
        self.close()

    @property
    def room(self) -> int:
        return 0 if self._suspects else self.count - len(self._running)

    @property
    def busy(self) -> bool:
        return bool(self._running or self._suspects)

    def submit(self, tag: Hashable, function: Callable[[Any], Any], item: Any) -> None:
        if self._pool is None:
            # Forked threads are unsafe: workers are started afresh.
            context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
            self._pool = ProcessPoolExecutor(
                self.count, mp_context=context, initializer=_begin_worker
            )
        task = _Task(tag, function, item)
        try:
            with noticing(lambda: ""):  # a pool that is half started could not be stopped
                self._running[self._pool.submit(function, item)] = task
        except BrokenProcessPool:
            self._suspects.append(task)
            self._stop()

    def collect(self) -> list[tuple[Any, Any]]:
        """A process that died breaks the pool, and the task that killed it is not known: all that
        were under way are run again, one at a time, until each has a result or is guilty."""
        alone = not self._running
        if alone:
            self.submit(*self._suspects.popleft())
        done, _ = wait(self._running, return_when=FIRST_COMPLETED)
        outcomes: list[tuple[Any, Any]] = []
        broken = False
        for future in done:
            task = self._running.pop(future)
            try:
                outcomes.append((task.tag, future.result()))
            except BrokenProcessPool:
                broken = True
                if alone:
                    outcomes.append((task.tag, WorkerDied()))
                else:
                    self._suspects.append(task)
            except Exception as error:
                outcomes.append((task.tag, error))
        if broken:
            self._suspects.extend(self._running.values())
            self._running.clear()
            self._stop()
        return outcomes

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of each item, in order; the first exception of any is raised here."""
        waiting, found = deque(enumerate(items)), dict[int, Result]()
        while waiting or self.busy:
            while waiting and self.room > 0:
                index, item = waiting.popleft()
                self.submit(index, function, item)
            for index, outcome in self.collect():
                if isinstance(outcome, Exception):
                    self.close()
                    raise outcome
                found[index] = outcome
        return [found[index] for index in sorted(found)]

    def close(self) -> None:
        """Stop once the tasks in flight have ended; their outcomes are dropped.

        A signal meanwhile kills them, and is raised when they have ended.
        """
        self._suspects.clear()
        self._running.clear()
        self._stop()

    def _stop(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            with noticing(lambda: "", at_once=_kill):
                pool.shutdown(cancel_futures=True)


def _kill() -> None:
    for worker in multiprocessing.active_children():
        worker.kill()


def _begin_worker() -> None:
    """Ctrl-C reaches every process of a terminal, and the parent decides what ends; where the
    parent is killed, its workers would wait for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
