"""Benchmark of the start of the command line."""

import subprocess
import sys
from collections.abc import Sequence

from ._timing import Row, interleaved


def measured() -> Sequence[Row]:
    """The lists of commands and of one command's options, each in a fresh process."""
    lines = [["--help"], ["laser", "--help"]]
    seconds = interleaved([lambda line=line: _run(line) for line in lines])
    names = [f"armside {' '.join(line)}" for line in lines]
    return [Row(name, time) for name, time in zip(names, seconds, strict=True)]


def _run(line: list[str]) -> None:
    command = [sys.executable, "-m", "armside", *line]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
