"""Gear-error files: the transmission error found in the gears of one arm, in TOML.

    version = 1
    robot = "LARGE_ROBOT"                # name of the robot, as its robot file has it
    motors = 6                           # number of motors

    [[gear_error]]                       # any number of terms
    joint = 1                            # motor, from 1
    order = 220.0                        # periods per turn of the output
    amplitude = 1.1e-5                   # [rad], arm side, at most 0.01
    phase = 5.3                          # [rad]
    order_deviation = 0.1                # standard deviations, for information [optional]
    amplitude_deviation = 5e-7
    phase_deviation = 0.05

Numbers may be text with pi. A gear's output minus its motor angle is the sum of its terms
amplitude sin(order phi + phase), phi the motor angle on the arm side.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .dh import Robot
from .robot_file import GearTerm, gear_term, read_toml, refuse_unknown

VERSION = 1
LARGEST_ORDER, LARGEST_AMPLITUDE = 1e4, 0.01
"""Periods per turn, and [rad]: beyond them it is no gear's error."""
DEVIATIONS = ("order_deviation", "amplitude_deviation", "phase_deviation")
_KEYS = ("version", "robot", "motors", "gear_error")


def read_gear_file(file: Path, robot: Robot) -> tuple[GearTerm, ...]:
    """Terms of a gear-error file of this robot.

    Raises:
        ValueError: the file is not as described above, or is of another robot; the message begins
            with the name of the file.
        OSError: the file cannot be read.
    """
    return read_toml(file, lambda data: _terms(data, robot))


def gear_toml(
    robot: Robot, terms: Sequence[GearTerm], deviations: Sequence[tuple[float, float, float]]
) -> str:
    """Text of a file. deviations: of order, amplitude and phase of each term."""
    import tomlkit

    rows = list[dict[str, float]]()
    for term, own in zip(terms, deviations, strict=True):
        finite = zip(DEVIATIONS, own, strict=True)
        rows.append(term._asdict() | {name: dev for name, dev in finite if dev < LARGEST_ORDER})
    head = {"version": VERSION, "robot": robot.name, "motors": robot.n_joints}
    return tomlkit.dumps(head | {"gear_error": rows})


def _terms(data: Mapping[str, Any], robot: Robot) -> tuple[GearTerm, ...]:
    if "version" not in data or "gear_error" not in data:
        raise ValueError("is no gear-error file: it needs version and [[gear_error]]")
    if data["version"] != VERSION:
        raise ValueError(f"version must be {VERSION}, got {data['version']!r}")
    refuse_unknown("the file", data, _KEYS)
    if (name := data.get("robot")) != robot.name:
        raise ValueError(f"is of robot {name!r}, not of {robot.name!r}")
    if (motors := data.get("motors")) != robot.n_joints:
        raise ValueError(f"motors must be {robot.n_joints}, got {motors!r}")
    rows = data["gear_error"]
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ValueError("gear_error must be tables [[gear_error]]")
    return tuple(_term(f"gear_error {k}", robot, row) for k, row in enumerate(rows, 1))


def _term(where: str, robot: Robot, row: Mapping[str, Any]) -> GearTerm:
    refuse_unknown(where, row, (*GearTerm._fields, *DEVIATIONS))
    term = gear_term(where, robot, {name: row[name] for name in GearTerm._fields if name in row})
    for name, most in (("order", LARGEST_ORDER), ("amplitude", LARGEST_AMPLITUDE)):
        if abs(value := getattr(term, name)) > most:
            raise ValueError(f"{where}: {name} must be at most {most:g}, got {value:g}")
    return term
