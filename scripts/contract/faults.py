"""Faults that a process brings on itself, to see what a command line leaves behind."""

import os
import resource
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from shutil import rmtree
from typing import Any

from armside.sim.records.atomic import STAGED

FULL = 600
"""[bytes], that a file can grow to: less than any result, more than an error of one line."""


def disk_full() -> None:
    """No file can grow. Python writes no bytecode: it would keep what was cut short."""
    sys.dont_write_bytecode = True
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, most))


def killed() -> None:
    """The process is killed in the moment before its first result gets its name."""
    _before_naming(lambda _: os.kill(os.getpid(), signal.SIGKILL))


def terminated() -> None:
    """The process is asked to end in that moment."""
    _before_naming(lambda _: os.kill(os.getpid(), signal.SIGTERM))


def removed() -> None:
    """The unfinished result is removed in that moment."""
    _before_naming(lambda left: rmtree(left) if left.is_dir() else left.unlink())


def no_stdout() -> None:
    """The process begins without a standard output."""
    os.close(1)


def no_home() -> None:
    """Neither home nor cache can be written, or exist at all."""
    for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR"):
        os.environ[name] = "/proc/none"


def _before_naming(act: Callable[[Path], Any]) -> None:
    for name in ("rename", "replace"):
        setattr(os, name, _hooked(getattr(os, name), act))


def _hooked(real: Callable[..., None], act: Callable[[Path], Any]) -> Callable[..., None]:
    def naming(source: Any, *others: Any, **options: Any) -> None:
        if STAGED.fullmatch(Path(source).name):
            act(Path(source))
        real(source, *others, **options)

    return naming
