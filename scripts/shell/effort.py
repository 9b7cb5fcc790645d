"""Estimates of time and memory, by which absurd counts and durations are refused before the start.

The estimates are rounded up from measurements of one core: they shall find what is out of
proportion, not predict. A limit applies to what a person can have asked for by mistake alone.
"""

import os
from dataclasses import dataclass

from .errors import InputError

HOUR, DAY, YEAR = 3600.0, 86400.0, 3.156e7
"""[s]."""
LONGEST = DAY
"""[s], of work whose results appear at its end."""
LONGEST_KEPT = YEAR
"""[s], of work that is kept as it is done, and can go on after an interruption."""
MEMORY_PART = 0.8
"""Part of this machine's memory that a command may be estimated to take."""
START = 0.4e9
"""[bytes], of a process with all libraries."""
SECONDS = {"years": YEAR, "days": DAY, "hours": HOUR, "minutes": 60.0, "s": 1.0}
SMALLEST = SECONDS | {"years": 2.0 * YEAR, "days": 2.0 * DAY}
"""Shortest duration [s] that is given in a unit."""


@dataclass(frozen=True)
class Effort:
    """Estimate of what a command takes."""

    seconds: float = 0.0
    bytes: float = 0.0

    def __mul__(self, n: float) -> "Effort":
        return Effort(n * self.seconds, n * self.bytes)

    def __add__(self, other: "Effort") -> "Effort":
        return Effort(self.seconds + other.seconds, self.bytes + other.bytes)


def refuse_absurd(what: str, effort: Effort, *, kept: bool = False) -> None:
    """Raise InputError for work that is out of proportion. what: begin of the message, such as "5
    runs". kept: finished parts survive an interruption."""
    longest = LONGEST_KEPT if kept else LONGEST
    if not effort.seconds <= longest:
        takes, most = duration(effort.seconds), duration(longest)
        raise InputError(f"{what} would take about {takes}; at most {most} are begun")
    most = MEMORY_PART * memory()
    if not START + effort.bytes <= most:
        takes, most = size(START + effort.bytes), size(most)
        raise InputError(f"{what} would need about {takes} of memory; at most {most} are taken")


def duration(seconds: float) -> str:
    """Seconds in a unit that suits them."""
    unit = next((unit for unit, least in SMALLEST.items() if seconds >= least), "s")
    return f"{seconds / SECONDS[unit]:.3g} {unit}"


def size(n: float) -> str:
    """Bytes in gigabytes."""
    return f"{n / 1e9:.3g} GB"


def memory() -> int:
    """Memory of this machine [bytes]."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
