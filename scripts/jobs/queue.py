"""Jobs on their way to rows in a folder: the one queue of sweep and reproduce."""

import time
from collections import Counter, deque
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from .blocks import FAILED, Block, Blocks, Row
from .store import Job

POLL = 0.2
"""[s], between two looks at blocks that another process holds."""
KNOWN, KNOWN_FAILED = "known", "known (failed)"
"""Outcomes of jobs whose rows were there before."""


class Engine(Protocol):
    """Runs tasks, some at a time, and returns their outcomes in any order."""

    @property
    def room(self) -> int:
        """Tasks that can start now. No more are taken on: they may be left to another process."""
        ...

    @property
    def busy(self) -> bool:
        """Tasks are under way."""
        ...

    def submit(self, tag: Hashable, function: Callable[[Any], Any], item: Any) -> None:
        """Start function(item)."""

    def collect(self) -> list[tuple[Any, Any]]:
        """Wait for tasks under way; the tag of each with its result or the exception that it
        raised. At least one, or none while the engine recovers."""
        ...

    def close(self) -> None:
        """Stop; the outcomes of what is under way are dropped."""


def run(job: Job) -> Any:
    """The result of a job."""
    return job.run()


@dataclass(kw_only=True)
class Queue:
    """Jobs on their way through an engine into the blocks of a folder."""

    blocks: Blocks
    engine: Engine
    row: Callable[[str, Any], Row | None]
    """The row that a key and the outcome of its job become; None keeps nothing."""
    done: Callable[[str], None] = lambda key: None
    """Called with the key of each job that has an outcome."""
    retry_failed: bool = False
    waiting: Callable[[int], None] = lambda n: None
    """Called once nothing is left to do but to wait for others, with the number of jobs that they
    have claimed."""

    def complete(self, jobs: Mapping[str, Job]) -> Counter[str]:
        """Bring the folder up to all jobs, by key, started in their order.

        Returns:
            The number of jobs by status: that of their new rows, `failed` where there is none, and
            `known` or `known (failed)` for rows that were there before.

        Raises:
            RunFailed: the folder's file system has no locks, or a part is damaged and not
                expendable.
            OSError: the folder cannot be written to. The rows before are kept.
        """
        self._jobs: dict[str, dict[str, Job]] = {}
        for key, job in jobs.items():
            self._jobs.setdefault(self.blocks.name(key), {})[key] = job
        self._unclaimed, self._held_elsewhere = deque(self._jobs), deque[str]()
        self._ready = deque[tuple[str, Job]]()
        self._ours: dict[str, Block] = {}
        self._left, self._counts = Counter[str](), Counter[str]()
        told = False
        try:
            while self._unclaimed or self._held_elsewhere or self._ready or self.engine.busy:
                self._fill()
                # Only now: writing a part takes time in which workers would have nothing to do.
                self._close_finished()
                if self.engine.busy:
                    for key, outcome in self.engine.collect():
                        self._keep(key, outcome)
                elif self._held_elsewhere:
                    if not told:
                        self.waiting(sum(len(self._jobs[name]) for name in self._held_elsewhere))
                        told = True
                    time.sleep(POLL)
                if not (self._unclaimed or self._ready):
                    self._unclaimed, self._held_elsewhere = self._held_elsewhere, deque()
        finally:
            for block in self._ours.values():
                block.close()
        return self._counts

    def _fill(self) -> None:
        """Give the engine what it can start now. A block is claimed when its turn has come: until
        then another process may have it."""
        while self.engine.room > 0 and (self._ready or self._unclaimed):
            if self._ready:
                key, job = self._ready.popleft()
                self.engine.submit(key, run, job)
            else:
                self._claim(self._unclaimed.popleft())

    def _claim(self, name: str) -> None:
        block = self.blocks.claim(name, retry_failed=self.retry_failed)
        if block is None:
            self._held_elsewhere.append(name)
            return
        self._ours[name] = block
        for key, job in self._jobs[name].items():
            if key in block.done:
                self._count(key, KNOWN_FAILED if key in block.failed else KNOWN)
            else:
                self._ready.append((key, job))
                self._left[name] += 1
        if not self._left[name]:
            self._ours.pop(name).close()

    def _keep(self, key: str, outcome: Any) -> None:
        row = self._added(key, self.row(key, outcome))
        if isinstance(row, ValueError):  # it fits no dataset, and fails alone
            row = self._added(key, self.row(key, row))
        self._left[self.blocks.name(key)] -= 1
        self._count(key, row["status"] if isinstance(row, dict) else FAILED)

    def _added(self, key: str, row: Row | None) -> Row | ValueError | None:
        """A row that is kept now, or why it cannot be."""
        try:
            if row is not None:
                self._ours[self.blocks.name(key)].add(row)
        except ValueError as error:
            return error
        return row

    def _count(self, key: str, status: str) -> None:
        self._counts[status] += 1
        self.done(key)

    def _close_finished(self) -> None:
        for name in [name for name in self._ours if not self._left[name]]:
            self._ours.pop(name).close()
