"""Marks of processes, by which another one on the same machine can tell that they are dead."""

import os
from pathlib import Path

PROC = Path("/proc")


def own_mark() -> str:
    """Mark of this process: machine and process space, number, time of its start. Empty where the
    system does not tell them."""
    pid = os.getpid()
    started = _start(pid)
    return f"{_machine()} {pid} {started}" if started else ""


def is_dead(mark: str) -> bool:
    """The process of a mark has run on this machine, and runs no more."""
    machine, _, process = mark.partition(" ")
    pid, _, started = process.partition(" ")
    return pid.isdigit() and machine == _machine() and _start(int(pid)) != started


def _machine() -> str:
    """Name of this machine since it was switched on, and of the numbering of its processes."""
    try:
        boot = (PROC / "sys/kernel/random/boot_id").read_text().strip()
        return f"{boot}/{(PROC / 'self/ns/pid').readlink()}"
    except OSError:
        return "unknown"


def _start(pid: int) -> str:
    """Time of a process's start, in ticks since the machine's; empty for none."""
    try:
        fields = (PROC / f"{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return ""
    return "" if fields[0] == "Z" else fields[19]
