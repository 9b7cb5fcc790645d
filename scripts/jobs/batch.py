"""Jobs of a report on all cores, with results that are stored as they come and not run again."""

from collections.abc import Callable, Iterable
from typing import Any

from ..shell.errors import RunFailed, one_line
from .blocks import Row
from .queue import Engine, Queue
from .store import Job, Store, digest, row
from .workers import WorkerDied


def missing(jobs: Iterable[Job], store: Store) -> list[Job]:
    """Jobs without a result, each once, the longest first: so that no core waits at the end."""
    distinct = {digest(job): job for job in jobs if not store.holds(job)}
    return sorted(distinct.values(), key=lambda job: -job.cost)


def run_batch(
    jobs: list[Job],
    store: Store,
    *,
    workers: Engine,
    done: Callable[[float], None] = lambda cost: None,
) -> None:
    """Run jobs that no other process has run or is running; `done` gets the cost of each.

    Raises:
        RunFailed: a worker was killed, or jobs failed. Everything that finished is stored.
        OSError: a result could not be written. Those before it are stored.
    """
    by_key = {digest(job): job for job in jobs}
    failed: dict[str, Exception] = {}

    def kept(key: str, outcome: Any) -> Row | None:
        if isinstance(outcome, Exception):
            failed[key] = outcome
            return None
        return row(key, outcome)

    Queue(
        blocks=store.blocks, engine=workers, row=kept, done=lambda key: done(by_key[key].cost)
    ).complete(by_key)
    if not failed:
        return
    n, n_failed, (key, error) = len(jobs), len(failed), next(iter(failed.items()))
    where = f"{n - n_failed} of {n} experiments finished and are kept in {store.folder.parent}"
    if isinstance(error, WorkerDied):
        raise RunFailed(f"{error}; {where}") from error
    raise RunFailed(
        f"{n_failed} of {n} experiments failed, the first with "
        f"{type(error).__name__}: {one_line(error)} ({by_key[key]}); {where}"
    ) from error
