"""Benchmark of the start of the command line."""

import subprocess
import sys
from collections.abc import Sequence
from functools import partial

from ._timing import Row, timed


def measured() -> Sequence[Row]:
    """The lists of commands and of one command's options, each in a fresh process."""
    lines = ("armside --help", "armside laser --help")
    return timed({line: partial(_run, line) for line in lines})


def _run(line: str) -> None:
    command = [sys.executable, "-m", *line.split()]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
