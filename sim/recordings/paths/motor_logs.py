"""Motor logs of an ABB IRB6640 along one path, rpiRobotics/ARM-21-02-F-19-Robot-Motion-Program.

A folder has command.csv, waypoints as a motion program (p_bp: position of the tool [mm], q_bp:
motor angles [rad]), and logs *_vSPEED_*.csv of repeated runs: timestamp [s], cmd_num (-1 before the
start, else the command under way), J1 .. J6 [deg]. SPEED is the programmed one [mm/s].
"""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.arrays import Array

from ...records.files import LARGEST_DATA, check_file
from ..recording import Stream

MM = 1e-3
NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
SPEED = re.compile(r"_v(\d+\.?\d*)_")
FEWEST = 30
"""Waypoints and samples of a log."""
SLOWEST, FASTEST = 5e-3, 5.0
"""[m/s], programmed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotorLog:
    """One run along the path."""

    name: str
    speed: float
    """Programmed [m/s]."""
    motors: Stream
    """(N, 6) [rad], after the approach to the path."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PathLogs:
    """Waypoints of a path, and the logs of repeated runs along it."""

    position: Array
    """(W, 3) [m], of the tool, base axes."""
    phi: Array
    """(W, 6) [rad], motor angles there."""
    logs: tuple[MotorLog, ...]

    @property
    def speeds(self) -> tuple[float, ...]:
        """Programmed speeds [m/s], rising."""
        return tuple(sorted({log.speed for log in self.logs}))


def read_path_logs(folder: Path) -> PathLogs:
    """Waypoints and logs of a folder. Raises ValueError for files that are missing or damaged."""
    if not (folder / "command.csv").is_file():
        raise ValueError(f"{folder} is no folder of path logs: it needs command.csv")
    position, phi = _waypoints(check_file(folder / "command.csv", LARGEST_DATA))
    files = [file for file in sorted(folder.glob("*.csv")) if SPEED.search(file.name)]
    if not files:
        raise ValueError(f"{folder} has no logs: names must hold the speed, as in run_0_v75.0_.csv")
    return PathLogs(position=position, phi=phi, logs=tuple(_log(file) for file in files))


def _waypoints(file: Path) -> tuple[Array, Array]:
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    found = [[_numbers(row.get(name)) for row in rows] for name in ("p_bp", "q_bp")]
    for name, width, values in zip(("p_bp", "q_bp"), (3, 6), found, strict=True):
        if wrong := [k + 1 for k, one in enumerate(values) if len(one) != width]:
            raise ValueError(f"{file.name}: row {wrong[0]} must have {width} numbers in {name}")
    if len(rows) < FEWEST:
        raise ValueError(f"{file.name}: at least {FEWEST} waypoints are needed, got {len(rows)}")
    return MM * np.array(found[0]), np.array(found[1])


def _numbers(text: str | None) -> list[float]:
    return [float(number) for number in NUMBER.findall((text or "").replace("array", ""))]


def _log(file: Path) -> MotorLog:
    match = SPEED.search(file.name)
    assert match
    try:
        table = np.loadtxt(check_file(file, LARGEST_DATA), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from error
    if table.shape[1] != 8:
        raise ValueError(f"{file.name} must have 8 columns, got {table.shape[1]}")
    under_way = table[:, 1] > table[table[:, 1] >= 0.0, 1].min(initial=np.inf)
    table = table[under_way & np.isfinite(table).all(axis=1)]
    if len(table) < FEWEST:
        raise ValueError(f"{file.name}: {len(table)} samples under way, at least {FEWEST} needed")
    if (back := np.diff(table[:, 0]) <= 0.0).any():
        stamp = table[int(np.argmax(back)) + 1, 0]
        raise ValueError(f"{file.name}: the clock stands still or runs backwards at {stamp:g} s")
    speed = MM * float(match.group(1))
    if not SLOWEST <= speed <= FASTEST:
        text = f"from {SLOWEST / MM:g} to {FASTEST / MM:g} mm/s"
        raise ValueError(f"{file.name}: the speed must be {text}, got {speed / MM:g}")
    motors = Stream(table[:, 0], np.radians(table[:, 2:]))
    return MotorLog(name=file.stem, speed=speed, motors=motors)
