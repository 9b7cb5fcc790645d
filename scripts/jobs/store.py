"""Results of experiments in a folder, each under a hash of its configuration and of the code.

A result is written whole or not at all, so a killed process leaves only finished ones. A result of
other code, another version of the physics or another configuration is never taken for this one.
"""

import hashlib
import json
import zipfile
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import armside
from armside.sim.records.atomic import atomic
from armside.sim.records.summary import plain

Result = dict[str, NDArray[Any]]
"""Small named arrays."""

PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
_SUFFIXES = (".py", ".xml", ".toml")
"""Of code, robots and motion programs."""


class Job(Protocol):
    """A frozen dataclass that can run itself, in any process."""

    @property
    def cost(self) -> float:
        """Relative; for the time left."""
        ...

    def run(self) -> Result: ...


class Store:
    """Results of jobs in one folder, made when the first is saved."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def file(self, job: Job) -> Path:
        """Where the result of a job is, or will be."""
        return self.folder / f"{digest(job)}.npz"

    def holds(self, job: Job) -> bool:
        """A complete result is there; a damaged file counts as none."""
        file = self.file(job)
        return file.is_file() and zipfile.is_zipfile(file)

    def load(self, job: Job) -> Result:
        """The result of a job that is held."""
        with np.load(self.file(job), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def save(self, job: Job, result: Result) -> None:
        """Write a result whole. Raises OSError, e.g. on a full disk, leaving no part of it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic(self.file(job)) as partial, partial.open("wb") as file:
            # A file object: given a path, savez would append a suffix of its own.
            np.savez(file, **result)  # type: ignore[arg-type]


def digest(job: Job) -> str:
    """Names a job and all that its result depends on."""
    kind = type(job)
    what = {
        "job": f"{kind.__module__}.{kind.__qualname__}",
        "config": plain(job),
        "code": code_fingerprint(kind.__module__),
    }
    return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]


@cache
def code_fingerprint(module: str) -> str:
    """Hash of all our code, of the robots, of a job's module where that is not ours, and of the
    versions of others."""
    hashed = hashlib.sha256()
    ours = Path(armside.__file__).parent
    if not module.startswith("armside."):
        hashed.update(Path(str(import_module(module).__file__)).read_bytes())
    for package in PACKAGES:
        for file in sorted(f for f in (ours / package).rglob("*") if f.suffix in _SUFFIXES):
            hashed.update(file.relative_to(ours).as_posix().encode() + b"\0")
            hashed.update(file.read_bytes())
    for name in ("armside", "mujoco", "numpy"):
        hashed.update(f"{name} {version(name)}".encode())
    return hashed.hexdigest()
