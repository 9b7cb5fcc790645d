"""Files that appear whole or not at all: written under a hidden name, then renamed.

Whoever writes under a hidden name holds a lock (flock) on it, which the kernel releases when its
process dies: so the next one in the same place can tell what a dead process has left, and removes
it.
"""

import fcntl
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

STAGED = re.compile(r"\.(?P<name>.+)\.[0-9a-f]{8}\.partial")
"""Hidden name of a file or folder that is not finished."""


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Hidden file that becomes `path` only when the block ends without an error."""
    remove_stale(path.parent, path.name)
    with staged(path) as partial:
        yield partial
        partial.replace(path)


@contextmanager
def staged(path: Path, *, folder: bool = False) -> Iterator[Path]:
    """A new hidden file or folder beside `path` that is ours until the block ends, which removes it
    unless it has been renamed."""
    partial, lock = _claimed(path, folder=folder)
    try:
        yield partial
    finally:
        os.close(lock)
        if folder:
            shutil.rmtree(partial, ignore_errors=True)
        else:
            partial.unlink(missing_ok=True)


def write_bytes(file: Path, content: bytes) -> None:
    """Write a file so that it is complete or as it was before."""
    with atomic(file) as partial:
        partial.write_bytes(content)


def write_whole(file: Path, text: str) -> None:
    """Write a text file so that it is complete or as it was before."""
    write_bytes(file, text.encode("utf-8"))


def remove_stale(folder: Path, name: str | None = None) -> None:
    """Remove what dead processes have left in a folder, of a file or folder `name` if given, but
    what is locked or another user's."""
    with suppress(OSError):
        for left in sorted(os.listdir(folder)):
            found = STAGED.fullmatch(left)
            if found and name in (None, found["name"]):
                with suppress(OSError):
                    _remove(folder / left)


def _claimed(path: Path, *, folder: bool) -> tuple[Path, int]:
    """A new hidden file or folder beside `path`, and the descriptor that holds its lock."""
    while True:
        partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
        if folder:
            partial.mkdir()
        flags = os.O_RDONLY if folder else os.O_RDWR | os.O_CREAT | os.O_EXCL
        lock = os.open(partial, flags, 0o666)
        with suppress(OSError):  # without locks nobody can be taken for dead
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # A process that looked between the two calls may have taken us for dead.
        with suppress(FileNotFoundError):
            if os.stat(partial).st_ino == os.fstat(lock).st_ino:
                return partial, lock
        os.close(lock)


def _remove(left: Path) -> None:
    lock = os.open(left, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # OSError while its owner lives
        if left.is_dir():
            shutil.rmtree(left)
        else:
            left.unlink()
    finally:
        os.close(lock)
