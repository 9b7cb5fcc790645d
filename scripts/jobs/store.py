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
from .queue import DONE, FAILED, complete
from .workers import Engine, WorkerDied

Result = dict[str, NDArray[Any]]
"""Small named arrays."""

OURS = Path(armside.__file__).parent
PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
_SUFFIXES = (".py", ".xml", ".toml", ".json", ".npz")
"""Of code, robots, motion programs, designs and policies."""


class Job(Protocol):
    """A frozen dataclass that results in arrays."""

    @property
    def cost(self) -> float:
        """Relative; for the order of jobs and the time left."""
        ...

    def run(self) -> Result:
        """Its result, in any process."""
        ...


class Store:
    """Results of jobs in one folder, made when the first is kept: a file DIGEST.npz each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.errors = dict[str, Exception]()
        """Of the jobs that failed in this process, by key."""

    def load(self, job: Job) -> Result:
        """The result of a job that has one."""
        return self._arrays(digest(job))

    def status(self, key: str) -> str | None:
        """See `queue.Results`; a file that is damaged anywhere counts as none."""
        try:
            self._arrays(key)
        except (OSError, ValueError, KeyError, EOFError, BadZipFile):
            return None
        return DONE

    def keep(self, key: str, job: Job, outcome: Result | Exception) -> str:
        """See `queue.Results`; of an exception nothing is stored."""
        if isinstance(outcome, Exception):
            self.errors[key] = outcome
            return FAILED
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic(self.folder / f"{key}.npz") as partial, open(partial, "wb") as file:
            np.savez(file, **outcome)  # type: ignore[arg-type]
        return DONE

    def _arrays(self, key: str) -> Result:
        with open(self.folder / f"{key}.npz", "rb") as stream, npz(stream) as arrays:
            return {name: arrays[name] for name in arrays.files}


def digest(job: Job) -> str:
    """Names a job and all that its result depends on."""
    kind = type(job)
    of = {
        "job": f"{kind.__module__}.{kind.__qualname__}",
        "config": plain(job),
        "code": code_fingerprint(kind.__module__),
    }
    return digest_of(of)[:24]


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
    distinct = {digest(job): job for job in jobs}
    left = [job for key, job in distinct.items() if store.status(key) is None]
    return sorted(left, key=lambda job: -job.cost)


def run_batch(
    jobs: list[Job],
    store: Store,
    *,
    workers: Engine,
    done: Callable[[float], None] = lambda cost: None,
) -> None:
    """Run jobs that no other process has run or is running; `done` gets the cost of each. Raises
    RunFailed where a worker was killed or jobs failed, and OSError where a result could not be
    written. Everything that finished is stored."""
    by_key = {digest(job): job for job in jobs}
    complete(by_key, store, workers, done=lambda key: done(by_key[key].cost))
    failed = [(by_key[key], error) for key, error in store.errors.items() if key in by_key]
    if not failed:
        return
    n, n_failed, (job, error) = len(jobs), len(failed), failed[0]
    where = f"{n - n_failed} of {n} experiments finished and are kept in {store.folder.parent}"
    if isinstance(error, WorkerDied):
        raise RunFailed(f"{error}; {where}") from error
    raise RunFailed(
        f"{n_failed} of {n} experiments failed, the first with "
        f"{type(error).__name__}: {one_line(error)} ({job}); {where}"
    ) from error
