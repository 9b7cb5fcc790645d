"""The process that a command has for itself: its streams, warnings and signals."""

import os
import sys

from .interrupts import SIGNALS


def begin(*, debug: bool) -> None:
    """Prepare the process of a command line.

    Streams that the caller has closed lead nowhere: a file must not take their place. What stdout
    cannot encode is escaped. Warnings and log records of libraries are for those who debug.
    """
    for descriptor in range(3):
        _open(descriptor)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    sys.stderr.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    if not debug:
        _silence_libraries()
    SIGNALS.handle()


def _open(descriptor: int) -> None:
    try:
        os.fstat(descriptor)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_RDWR), descriptor)


def _silence_libraries() -> None:
    import logging
    import warnings

    logging.lastResort = logging.NullHandler()  # pyright: ignore[reportAttributeAccessIssue]
    if not sys.warnoptions:  # which `python -W` sets
        warnings.simplefilter("ignore")
        os.environ.setdefault("PYTHONWARNINGS", "ignore")  # for worker processes
