"""The folder of one run: complete, or not there.

Files are written into a hidden folder beside the destination, which is renamed when the run is
complete. An interrupted run removes it; that of a killed one is removed by the next run there.
"""

import os
from datetime import datetime
from itertools import count
from pathlib import Path

from .atomic import remove_stale, staged
from .files import InputError, check_can_write, check_name

RUNS = Path("runs")
PUBLISHED: list[Path] = []
"""Folders that this process has finished."""
FORMAT = 1
"""Format of a run's folder; raised when an older one can no longer be read."""


def check_destination(path: Path) -> None:
    """Raise InputError unless a run's folder can be renamed to `path`: new, or an empty folder."""
    check_name(path)
    if not path.exists():
        if not (parent := _existing_parent(path)).is_dir():
            raise InputError(f"{parent} is not a folder")
    elif not path.is_dir():
        raise InputError(f"{path} is a file; give a folder that is new or empty")
    elif any(path.iterdir()):
        raise InputError(f"{path} is not empty; give a folder that is new or empty")
    elif path.samefile(Path.cwd()) or os.path.ismount(path):
        raise InputError(f"{path} is in use; give a new folder inside it")


def check_writable(path: Path) -> None:
    """Raise InputError where no folder can be made at `path`, before long work is begun."""
    check_name(path)
    parent = _existing_parent(path)
    if not (parent.is_dir() and os.access(parent, os.W_OK | os.X_OK)):
        raise InputError(f"no folder can be made in {parent}")
    check_can_write(parent)


def check_shared_folder(path: Path) -> None:
    """Raise InputError where files cannot be added to the folder `path`, which may be new."""
    check_name(path)
    if not path.exists():
        check_writable(path)
    elif not path.is_dir():
        raise InputError(f"{path} is a file; give a folder")
    else:
        check_can_write(path)


def _existing_parent(path: Path) -> Path:
    return next(p for p in path.absolute().parents if p.exists())


class RunFolder:
    """Collects the files of one run; `path` is the finished folder once the block has ended.

    out: the folder asked for, new or empty; None makes `runs/<experiment>-<date>-<time>-<seed>`.
    """

    path: Path

    def __init__(self, experiment: str, *, seed: int, out: Path | None = None) -> None:
        if out is not None:
            check_destination(out)
        self._fixed = out is not None
        self.path = out or RUNS / f"{experiment}-{datetime.now():%Y%m%d-%H%M%S}-{seed}"

    def __enter__(self) -> "RunFolder":
        target = self.path.resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        remove_stale(target.parent)
        self._claim = staged(target, folder=True)
        self._staging = self._claim.__enter__()
        return self

    def __truediv__(self, name: str) -> Path:
        """Path of the file `name` while the block runs."""
        return self._staging / name

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        try:
            if error is None:
                self._publish()
        finally:
            self._claim.__exit__(None, None, None)

    def _publish(self) -> None:
        """Rename to the destination; two default names of one second differ by a suffix."""
        first = self.path
        for n in count(2):
            try:
                self._staging.rename(self.path.resolve())
                PUBLISHED.append(self.path)
                return
            except OSError:
                if self._fixed or not self.path.exists():
                    raise
                self.path = first.with_name(f"{first.name}-{n}")
