"""Arrays that jobs result in, each under a digest of its configuration and of the code.

A result is written whole or not at all, so a killed process leaves only finished ones. A result of
other code, another version of the physics or another configuration is never taken for this one.
"""

import hashlib
import io
import json
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol
from zipfile import BadZipFile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

import armside
from armside.sim.records.summary import plain

from .blocks import Block, Blocks, Row

Result = dict[str, NDArray[Any]]
"""Small named arrays."""

OURS = Path(armside.__file__).parent
PACKAGES = ("assets", "kinematics", "ilc", "sim", "scripts")
_SUFFIXES = (".py", ".xml", ".toml", ".json", ".npz")
"""Of code, robots, motion programs, designs and policies."""
_DIGITS = 24
_SCHEMA = pa.schema([("key", pa.string()), ("status", pa.string()), ("arrays", pa.binary())])


class Job(Protocol):
    """A frozen dataclass that can run itself, in any process."""

    @property
    def cost(self) -> float:
        """Relative; for the order of jobs and the time left."""
        ...

    def run(self) -> Any:
        """Its result: arrays for a `Store`, a row for a sweep."""


class Store:
    """Results of jobs in one folder, made when the first is saved: blocks of one row each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.blocks = Blocks(folder, _SCHEMA, digits=_DIGITS, expendable=True)

    def file(self, job: Job) -> Path:
        """Where the result of a job is, or will be."""
        return self.blocks.part(digest(job))

    def holds(self, job: Job) -> bool:
        """A complete result is there; a damaged file counts as none, wherever it is damaged."""
        try:
            self.load(job)
        except (OSError, ValueError, pa.ArrowException, BadZipFile):
            return False
        return True

    def load(self, job: Job) -> Result:
        """The result of a job that is held."""
        (packed,) = pq.read_table(self.file(job), columns=["arrays"])["arrays"].to_pylist()
        with np.load(io.BytesIO(packed), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def save(self, job: Job, result: Result) -> None:
        """Write a result whole, unless another process is just doing so. Raises OSError, e.g. on a
        full disk, leaving no part of it."""
        block: Block | None = self.blocks.claim(digest(job))
        if block is not None:
            try:
                block.add(row(digest(job), result))
            finally:
                block.close()


def row(key: str, result: Result) -> Row:
    """The row of a result in the blocks of a store."""
    packed = io.BytesIO()
    np.savez(packed, **result)  # type: ignore[arg-type]
    return {"key": key, "status": "done", "arrays": packed.getvalue()}


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
