"""Command lines in processes of their own, with limits and faults.

A server process imports everything once and forks for each line, without the second that Python
starts in.
"""

import contextlib
import faulthandler
import itertools
import multiprocessing
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import wait
from multiprocessing.context import ForkServerContext, ForkServerProcess
from pathlib import Path
from shutil import rmtree
from typing import Any, NamedTuple

from armside.sim.records.atomic import STAGED

FULL = 600
"""[bytes], that a file can grow to: less than any result, more than an error of one line."""


def disk_full() -> None:
    """No file can grow. Python writes no bytecode: it would keep what was cut short."""
    sys.dont_write_bytecode = True
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, most))


def signalled(number: int) -> None:
    """The process gets a signal in the moment before its first result gets its name."""
    _before_naming(lambda _: os.kill(os.getpid(), number))


killed, terminated, hung_up = (
    partial(signalled, number) for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP)
)


def overtaken() -> None:
    """Another run publishes its folder under the same name in that moment."""

    def publish(left: Path) -> None:
        found = STAGED.fullmatch(left.name)
        if left.is_dir() and found:
            left.with_name(found["name"]).mkdir(exist_ok=True)
            (left.with_name(found["name"]) / "theirs").touch()

    _before_naming(publish)


def clock_set_back() -> None:
    """The clock of the day goes back an hour whenever it is read."""
    now = itertools.count(time.time(), -3600.0)
    time.time = lambda: next(now)
    time.time_ns = lambda: int(1e9 * next(now))


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
    def naming(real: Callable[..., None], source: Any, *others: Any, **options: Any) -> None:
        if STAGED.fullmatch(Path(source).name):
            act(Path(source))
        real(source, *others, **options)

    for name in ("rename", "replace"):
        setattr(os, name, partial(naming, getattr(os, name)))


MODULES = (
    *("laser", "imu", "identify", "commission", "compare", "replay", "convert", "measure"),
    *("design", "identify_plant", "tune", "calibrate_arm", "gears", "cut", "export"),
)
PRELOADED = (
    *(f"armside.scripts.commands.{name}" for name in MODULES),
    *(f"armside.scripts.figures.{name}" for name in ("laser", "kerf", "design")),
    *("armside.sim.records.tables", "matplotlib.pyplot", "optuna"),
    *("tests.contract.isolated", "armside.ilc.analysis.proposal"),
)
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "ARROW_DEFAULT_MEMORY_POOL": "system"}
"""Environment in which those libraries start no threads: a fork copies locks, not their holders.
Rerun's start at its import, which is why it is not among them."""
ADDRESS_SPACE = 4_000_000_000
"""[bytes], beside that of the libraries: a hard limit, above the one of the contract."""
LARGEST_FILE = 500_000_000
"""[bytes], that a line may write."""
INTERRUPTED = 128 + signal.SIGINT
"""What a shell calls a process that Ctrl-C ended before or after `main` could answer it."""
LONGEST = 300.0
"""[s], in which a line must have ended, whatever it waits for. After half of it comes Ctrl-C."""

_POLLING = threading.Lock()
"""Held where a process is started or asked for its status: each start asks for those of all others,
and of two that read the same one's at once, one gets 255."""


class Outcome(NamedTuple):
    """End of a command line."""

    status: int | None
    """Negative: killed by that signal. None: it did not end."""
    out: str
    err: str
    interrupted: bool
    """It got Ctrl-C for running on."""
    seconds: float
    """Of the processor; 0 if it was killed."""
    memory: float
    """Largest resident set [bytes]; 0 if it was killed."""


def server() -> ForkServerContext:
    """The context whose processes are forked from a server with all libraries."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(PRELOADED))
    os.environ.update(ONE_THREAD)
    return context


def run(
    context: ForkServerContext,
    words: tuple[str, ...],
    folder: Path,
    patience: float,
    fault: Callable[[], None] | None = None,
) -> Outcome:
    """Run a command line in a folder, whose parent gets what it prints.

    patience: [s] of the processor, after which it gets Ctrl-C. fault: called in its process before
    it begins.
    """
    args = (words, str(folder), patience, fault)
    process: ForkServerProcess = context.Process(target=_main, args=args)
    with _POLLING:
        process.start()
    wait([process.sentinel], LONGEST)
    with _POLLING:
        status = process.exitcode
    if status == -signal.SIGINT:
        status = INTERRUPTED
    if status is None:
        process.kill()
        wait([process.sentinel])
    out, err, used = (_read(folder, name) for name in ("out", "err", "used"))
    interrupted, seconds, memory = map(float, (used or "0 0 0").split())
    return Outcome(status, out, err, bool(interrupted), seconds, memory)


def _read(folder: Path, name: str) -> str:
    with contextlib.suppress(FileNotFoundError):
        return folder.with_name(f"{folder.name}.{name}").read_text(errors="surrogateescape")
    return ""


def _main(
    words: tuple[str, ...], folder: str, patience: float, fault: Callable[[], None] | None
) -> None:
    os.environ.pop("DISPLAY", None)
    for descriptor, name in ((1, "out"), (2, "err")):
        file = os.open(f"{folder}.{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, descriptor)
        os.close(file)
    sys.stdout, sys.stderr = None, None  # as if they had been closed: `main` opens them
    faulthandler.enable(2)  # what ends on a signal says where
    os.chdir(folder)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a server ignores
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    most = taken + ADDRESS_SPACE
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
    for alarm in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(alarm, lambda *_: os.kill(os.getpid(), signal.SIGINT))
    signal.setitimer(signal.ITIMER_PROF, patience)
    signal.setitimer(signal.ITIMER_REAL, 0.5 * LONGEST)  # its workers may be what takes long
    from armside.scripts import cli
    from armside.scripts.shell.interrupts import SIGNALS

    if fault is not None:
        fault()
    sys.argv = ["armside", *words]
    status = cli.main()
    for timer in (signal.ITIMER_PROF, signal.ITIMER_REAL):
        signal.setitimer(timer, 0.0)
    used = resource.getrusage(resource.RUSAGE_SELF)
    seconds = used.ru_utime + used.ru_stime
    interrupted = len(SIGNALS.come) > 0
    Path(f"{folder}.used").write_text(f"{interrupted:d} {seconds} {1024 * used.ru_maxrss}")
    os._exit(status)
