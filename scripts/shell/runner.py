"""A command line carried out: parsed, run, and ended with one line and a status, in a process that
it may have for itself."""

import errno
import os
import sys
import traceback
from typing import TYPE_CHECKING, TextIO

from armside.sim.records.run_folder import PUBLISHED

from .errors import InputError, RunFailed, one_line, printable
from .help import BRIEF, WHOLE, overview
from .interrupts import SIGNALS, exit_status

if TYPE_CHECKING:
    from .parser import Commands, Load

DONE, FAILED, BAD_INPUT = 0, 1, 2
"""Exit status; that of an interruption is in `interrupts`."""
OF_NAMES = (errno.ENAMETOOLONG, errno.ELOOP)
"""Errors of the system that only what was typed can cause."""


def run(tokens: list[str], commands: "Commands", load: "Load") -> int:
    """Parse and run a command line; its exit status."""
    try:
        if not tokens or tokens[0] in (*BRIEF, WHOLE):
            print(overview(commands), flush=True)
            return DONE
        if backend := os.environ.get("MPLBACKEND"):
            _check_backend(backend)
        from .parser import parse  # which takes half of the time of the overview

        command, bound = parse(tokens, commands, load)
        PUBLISHED.clear()
        command(*bound.args, **bound.kwargs)
        SIGNALS.ignore()
        sys.stdout.flush()
        return DONE
    except BrokenPipeError:  # the reader of our output left: nobody reads a message
        _drop_unwritten(sys.stdout)
        return FAILED
    except (Exception, KeyboardInterrupt) as raised:
        SIGNALS.ignore()
        error = SIGNALS.consequence(raised) if isinstance(raised, Exception) else raised
        if isinstance(error, KeyboardInterrupt):
            left = f"; the results are complete in {PUBLISHED[-1]}" if PUBLISHED else ""
            kept = f"interrupted{left or ', nothing was kept'}"
            return _complain(str(error) or kept, exit_status(error))
        if "--debug" in tokens:
            traceback.print_exc()
        is_bad = isinstance(error, InputError) or getattr(error, "errno", None) in OF_NAMES
        return _complain(_message(error), BAD_INPUT if is_bad else FAILED)


def _check_backend(backend: str) -> None:
    """Refuse one that matplotlib does not know: importing it would fail, perhaps after the work."""
    try:
        import matplotlib as mpl  # noqa: F401
    except ValueError as error:
        text = f"the environment variable MPLBACKEND names {backend!r}, which is no backend"
        raise InputError(f"{text} of matplotlib: unset it") from error


def _message(error: Exception) -> str:
    if isinstance(error, MemoryError):
        return "failed for want of memory; ask for less"
    if isinstance(error, (InputError, RunFailed, OSError)):
        return one_line(error)
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    said = f": {printable(text)}" if text else ""
    return f"failed with {type(error).__name__}{said} (--debug shows where)"


def _complain(message: str, status: int) -> int:
    _drop_unwritten(sys.stdout)
    try:
        print(f"armside: {message}", file=sys.stderr, flush=True)
    except OSError:  # a full disk or nobody behind it: the status remains
        _drop_unwritten(sys.stderr)
    return status


def _drop_unwritten(stream: object) -> None:
    """Drop output that a stream does not take, or Python would fail on it once more at its end."""
    try:
        stream.flush()  # type: ignore[attr-defined]
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())  # type: ignore[attr-defined]


def begin(*, debug: bool) -> None:
    """Prepare the process of a command line. Streams that the caller has closed lead nowhere: a
    file must not take their place. What stdout cannot encode is escaped. Warnings and log records
    of libraries are for those who debug."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_RDWR), descriptor)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    sys.stderr.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    if not debug:
        import logging
        import warnings

        logging.lastResort = logging.NullHandler()  # pyright: ignore[reportAttributeAccessIssue]
        if not sys.warnoptions:  # which `python -W` sets
            warnings.simplefilter("ignore")
            os.environ.setdefault("PYTHONWARNINGS", "ignore")  # for worker processes
    if sys.stderr.isatty() and "--quiet" not in sys.argv:
        announce_compiling(sys.stderr, debug=debug)
    SIGNALS.handle()


def announce_compiling(stream: TextIO, *, debug: bool) -> None:
    """A line on a terminal for each function that is compiled: the first command of a new robot
    takes up to half a minute. Warnings of the cache are for those who debug."""
    import logging

    handler, log = logging.StreamHandler(stream), logging.getLogger("armside.kinematics.cache")
    handler.setFormatter(logging.Formatter("armside: %(message)s"))
    handler.addFilter(lambda record: debug or record.levelno == logging.INFO)
    log.addHandler(handler)
    log.setLevel(logging.INFO)
