"""Jobs on their way to one result a file in a folder, which several processes may share."""

import fcntl
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

from .workers import Engine

POLL = 0.2
"""[s], between two looks at jobs that another process has claimed."""
DONE, FAILED = "done", "failed"
"""Status of a result, and of a job without one."""
KNOWN, KNOWN_FAILED = "known", "known (failed)"
"""Outcomes of jobs whose results were there before."""


class Results(Protocol):
    """A folder with one result a file. What it holds under a key is never half of a result."""

    @property
    def folder(self) -> Path: ...

    def status(self, key: str) -> str | None:
        """Status of a stored result; None where there is none, or a damaged one."""
        ...

    def keep(self, key: str, job: Any, outcome: Any) -> str:
        """Store the outcome of a job, its result or an exception, so that a killed process does not
        lose it, and return its status. Raises OSError, such as on a full disk."""
        ...


class Claims:
    """Jobs that this process works on: a lock (flock) each, which the kernel releases when the
    process dies. On a file system without locks everybody has every job, to the same result."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._locks = folder / ".claims", dict[str, int]()

    def take(self, key: str) -> bool:
        """Claim a job, unless another process has it. Raises OSError where the folder cannot be
        written to."""
        self._folder.mkdir(parents=True, exist_ok=True)
        lock = os.open(self._folder / key, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            return False
        except OSError:  # no locks here
            pass
        self._locks[key] = lock
        return True

    def drop(self, *keys: str) -> None:
        """Let others have these jobs; all where none is given."""
        for key in keys or list(self._locks):
            (self._folder / key).unlink(missing_ok=True)
            os.close(self._locks.pop(key))


def complete(
    jobs: Mapping[str, Any],
    results: Results,
    engine: Engine,
    *,
    done: Callable[[str], None] = lambda key: None,
    retry_failed: bool = False,
    waiting: Callable[[int], None] = lambda n: None,
) -> Counter[str]:
    """Bring a folder up to all jobs, by key, started in their order: objects whose `run()` is their
    result, in any process. The number of jobs by status: that of their new results, and `known` or
    `known (failed)` for those that were there before.

    done: called with the key of each job that has an outcome. retry_failed: run jobs again that
    have failed before. waiting: called once nothing is left to do but to wait for others, with the
    number of jobs that they have claimed.

    Raises OSError where the folder cannot be written to. What was stored before stays.
    """
    counts, claims, announced = Counter[str](), Claims(results.folder), False
    left, held = dict(jobs), dict[str, Any]()

    def known(key: str) -> bool:
        status = results.status(key)
        if status is None or (retry_failed and status == FAILED):
            return False
        counts[KNOWN_FAILED if status == FAILED else KNOWN] += 1
        done(key)
        return True

    def ours() -> Iterator[tuple[str, Any]]:
        for key, job in left.items():
            if known(key):
                continue
            if not claims.take(key):
                held[key] = job
            elif known(key):  # another process has finished it in between
                claims.drop(key)
            else:
                yield key, job

    try:
        while left:
            for (key, job), outcome in engine.results(_run, ours()):
                counts[results.keep(key, job, outcome)] += 1
                claims.drop(key)
                done(key)
            if held:
                if not announced:
                    waiting(len(held))
                announced = True
                time.sleep(POLL)
            left, held = held, {}
    finally:
        claims.drop()
    return counts


def _run(pair: tuple[str, Any]) -> Any:
    return pair[1].run()
