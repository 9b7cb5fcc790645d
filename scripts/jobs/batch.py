"""Jobs on all cores: what is stored is not run again, what finishes is stored at once."""

from collections.abc import Callable, Iterable
from concurrent.futures.process import BrokenProcessPool

from ..shell.errors import RunFailed, one_line
from .store import Job, Result, Store
from .workers import Workers


def missing(jobs: Iterable[Job], store: Store) -> list[Job]:
    """Jobs without a result, each once, the longest first: so that no core waits at the end."""
    distinct = {store.file(job): job for job in jobs if not store.holds(job)}
    return sorted(distinct.values(), key=lambda job: -job.cost)


def run_batch(
    jobs: list[Job],
    store: Store,
    *,
    workers: Workers,
    done: Callable[[float], None] = lambda cost: None,
) -> None:
    """Run jobs and store each result as it comes; `done` is told the cost of each.

    Raises:
        RunFailed: a worker was killed, or jobs failed. Everything that finished is stored.
        OSError: a result could not be written. Those before it are stored.
    """
    failed: list[tuple[Job, Exception]] = []
    n_done = 0
    for job, outcome in workers.unordered(_run, jobs):
        if isinstance(outcome, Exception):
            failed.append((job, outcome))
            continue
        store.save(job, outcome)
        n_done += 1
        done(job.cost)
    if not failed:
        return
    kept = f"{n_done} of {len(jobs)} experiments finished and are kept in {store.folder.parent}"
    job, error = failed[0]
    if isinstance(error, BrokenProcessPool):
        raise RunFailed(f"a worker process was killed (out of memory?); {kept}") from error
    raise RunFailed(
        f"{len(failed)} of {len(jobs)} experiments failed, the first with "
        f"{type(error).__name__}: {one_line(error)} ({job}); {kept}"
    ) from error


def _run(job: Job) -> Result:
    return job.run()
