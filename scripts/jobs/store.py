"""Arrays that jobs result in, each under a digest of its configuration and of the code.

A result is written whole or not at all, so a killed process leaves only finished ones. A result of
other code, another version of the physics or another configuration is never taken for this one.
"""

import hashlib
import json
from collections.abc import Callable, Iterable
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

import armside
from armside.arrays import npz
from armside.sim.records.atomic import atomic
from armside.sim.records.summary import plain

from ..shell.errors import RunFailed, one_line
from . import queue
from .queue import DONE, FAILED, complete
from .workers import Engine, WorkerDied

Result = dict[str, NDArray[Any]]
"""Small named arrays."""

OURS = Path(armside.__file__).parent
PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
_SUFFIXES = (".py", ".xml", ".toml", ".json", ".npz")
"""Of code, robots, motion programs, designs and policies."""
_DIGITS = 24
_UNREADABLE = (OSError, ValueError, KeyError, EOFError, BadZipFile)


class Job(queue.Job, Protocol):
    """A job that results in arrays."""

    @property
    def cost(self) -> float:
        """Relative; for the order of jobs and the time left."""
        ...


class Store:
    """Results of jobs in one folder, made when the first is saved: a file DIGEST.npz each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.errors = dict[str, Exception]()
        """Of the jobs that failed in this process, by key."""

    def file(self, job: Job) -> Path:
        """Where the result of a job is, or will be."""
        return self._file(digest(job))

    def holds(self, job: Job) -> bool:
        """A complete result is there; a damaged file counts as none, wherever it is damaged."""
        return self.status(digest(job)) is not None

    def load(self, job: Job) -> Result:
        """The result of a job that is held."""
        return _arrays(self.file(job))

    def save(self, job: Job, result: Result) -> None:
        """Write a result whole. Raises OSError, e.g. on a full disk, leaving no part of it."""
        self._write(digest(job), result)

    def status(self, key: str) -> str | None:
        """See `queue.Results`."""
        try:
            _arrays(self._file(key))
        except _UNREADABLE:
            return None
        return DONE

    def keep(self, key: str, job: Job, outcome: Any) -> str:
        """See `queue.Results`; of an exception nothing is stored."""
        if isinstance(outcome, Exception):
            self.errors[key] = outcome
            return FAILED
        self._write(key, outcome)
        return DONE

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.npz"

    def _write(self, key: str, result: Result) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic(self._file(key)) as partial, open(partial, "wb") as file:
            np.savez(file, **result)  # type: ignore[arg-type]


def _arrays(file: Path) -> Result:
    with open(file, "rb") as stream, npz(stream) as arrays:
        return {name: arrays[name] for name in arrays.files}


def digest(job: Job) -> str:
    """Names a job and all that its result depends on."""
    kind = type(job)
    return digest_of(
        {
            "job": f"{kind.__module__}.{kind.__qualname__}",
            "config": plain(job),
            "code": code_fingerprint(kind.__module__),
        }
    )[:_DIGITS]


def digest_of(configuration: Any) -> str:
    """Hash of a configuration: of plain values, whatever the order of its entries."""
    return hashlib.sha256(json.dumps(configuration, sort_keys=True).encode()).hexdigest()


@cache
def code_fingerprint(module: str = armside.__name__) -> str:
    """Hash of all our code and data, of a job's module where that is not ours, and of the versions
    of others."""
    hashed = hashlib.sha256()
    if module.split(".")[0] != armside.__name__:
        hashed.update(Path(str(import_module(module).__file__)).read_bytes())
    for package in PACKAGES:
        for file in sorted(f for f in (OURS / package).rglob("*") if f.suffix in _SUFFIXES):
            hashed.update(file.relative_to(OURS).as_posix().encode() + b"\0")
            hashed.update(file.read_bytes())
    for name in ("armside", "mujoco", "numpy"):
        hashed.update(f"{name} {version(name)}".encode())
    return hashed.hexdigest()


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
    complete(by_key, store, workers, done=lambda key: done(by_key[key].cost))
    failed = {key: error for key, error in store.errors.items() if key in by_key}
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
