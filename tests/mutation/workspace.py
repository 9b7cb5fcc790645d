"""A copy of the tree in which one file at a time is mutated."""

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from .mutant import ROOT, Mutant


def copied(target: Path, root: Path = ROOT) -> Path:
    """Copy of the files that git knows or would add, with their times; links stay links."""
    listed = ("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    names = subprocess.run(listed, cwd=root, check=True, capture_output=True, text=True).stdout
    shutil.rmtree(target, ignore_errors=True)
    for name in filter(None, names.split("\0")):
        source, copy = root / name, target / name
        if source.is_symlink() or source.is_file():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, copy, follow_symlinks=False)
    return target


def commit(root: Path = ROOT) -> str:
    """Commit of a tree, `+` behind it where files differ from it; empty without a history."""
    found = []
    for command in ("rev-parse --short=10 HEAD", "status --porcelain --untracked-files=no"):
        done = subprocess.run(
            ("git", *command.split()), cwd=root, check=False, capture_output=True, text=True
        )
        if done.returncode != 0:
            return ""
        found.append(done.stdout.strip())
    return found[0] + ("+" if found[1] else "")


@contextlib.contextmanager
def mutated(mutant: Mutant, root: Path) -> Iterator[None]:
    """Mutate the file of a copied tree, and restore text, times and compiled code afterwards.

    A compiled function may contain one of another file of its folder, so the cache of the folder is
    put aside.
    """
    path = root / mutant.file
    text, times = path.read_text(encoding="utf-8"), path.stat()
    cache, aside = path.parent / "__pycache__", path.parent / "__pycache__.aside"
    if compiled := "njit" in text and cache.exists():
        cache.rename(aside)
    path.write_text(mutant.applied(text), encoding="utf-8")
    # a time of its own: bytecode is known by size and whole seconds
    moment = times.st_mtime + 1000.0 + int(mutant.key[:6], 16)
    os.utime(path, (moment, moment))
    try:
        yield
    finally:
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        if compiled:
            shutil.rmtree(cache, ignore_errors=True)
            aside.rename(cache)
