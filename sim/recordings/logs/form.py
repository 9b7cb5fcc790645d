"""Forms of controllers' logs: which columns hold time, angles and reference, and their units."""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...records.files import InputError, check_file, reading

TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
"""[s] of each unit of time."""
ANGLES = {"rad": 1.0, "deg": np.pi / 180.0, "°": np.pi / 180.0, "grad": np.pi / 180.0}
"""[rad] of each unit of angle; KUKA writes Grad, German for degree."""
DATE = "%"
"""In a unit of time: it is a format of dates (strptime)."""
PLACE = "{}"
"""In the name of a column: the number of the axis."""


@dataclass(frozen=True, kw_only=True)
class LogForm:
    """Columns of one kind of log. Units of None stand in the header, as in `A1 [deg]`."""

    name: str
    time: str
    time_unit: str | None = "s"
    motor_angle: str | tuple[str, ...]
    """Names of the columns, or one with {} in place of the axis."""
    reference: str | tuple[str, ...] = ()
    angle_unit: str | None = "deg"

    def __post_init__(self) -> None:
        for said, unit, known in (
            ("time_unit", self.time_unit, TIMES),
            ("angle_unit", self.angle_unit, ANGLES),
        ):
            date = said == "time_unit" and DATE in (unit or "")
            if unit is not None and unit.lower() not in known and not date:
                raise ValueError(f"{said} must be one of {', '.join(known)}, got {unit!r}")
        if isinstance(self.reference, tuple) and isinstance(self.motor_angle, tuple):
            n, own = len(self.motor_angle), len(self.reference)
            if own not in (0, n):
                raise ValueError(f"reference must name {n} columns as motor_angle, got {own}")

    def fits(self, header: Sequence[str]) -> bool:
        """True where a header has the columns of time and of the first axis."""
        return self.time in header and bool(self.motors(header))

    def motors(self, header: Sequence[str]) -> tuple[str, ...]:
        """Columns of the angles that a header has."""
        return _columns(self.motor_angle, header)

    def references(self, header: Sequence[str]) -> tuple[str, ...]:
        """Columns of the reference that a header has; empty where one is missing."""
        found = _columns(self.reference, header)
        return found if len(found) == len(self.motors(header)) else ()


def _columns(named: str | tuple[str, ...], header: Sequence[str]) -> tuple[str, ...]:
    if isinstance(named, tuple):
        return named
    pattern = re.compile(re.escape(named).replace(re.escape(PLACE), r"(\d+)"))
    found = {int(match[1]): match[0] for name in header if (match := pattern.fullmatch(name))}
    counted = range(1, len(found) + 1)
    return tuple(found[i] for i in counted) if list(counted) == sorted(found) else ()


_RSI = {"motor_angle": "Send.AIPos.A{}", "reference": "Send.ASPos.A{}"}
_TRACE = {"motor_angle": "AxisPos_Act{}", "reference": "AxisPos_CmdIpo{}"}
FORMS = (
    # rpiRobotics/abb_motion_program_exec, robot/HOME/motion_program_logger.mod: a RAPID task
    # writes clock and CJointT each 4 ms.
    LogForm(name="ABB, log of a RAPID task", time="timestamp", motor_angle="J{}"),
    # RSIPI 0.3, network_handler.py: what the controller sends each cycle. IPOC is its clock.
    LogForm(name="KUKA, RSI log by its clock", time="Send.IPOC", time_unit="ms", **_RSI),
    LogForm(name="KUKA, RSI log by its clock", time="Receive.IPOC", time_unit="ms", **_RSI),
    LogForm(name="KUKA, RSI log", time="Timestamp", time_unit="%d/%m/%Y %H:%M:%S.%f", **_RSI),
    # Trace of KUKA's controllers (KRC4, KRCIpo): a DIAdem file, or its text with tabulators.
    LogForm(name="KUKA, trace", time="Zeit", time_unit=None, angle_unit=None, **_TRACE),
    LogForm(name="KUKA, trace", time="Time", time_unit=None, angle_unit=None, **_TRACE),
)
"""Forms that are known by their headers; the first that fits is taken."""


TEXTS = ("time", "time_unit", "angle_unit")
NAMES = ("motor_angle", "reference")
NEEDED = ("time", "motor_angle")


def read_columns(file: Path) -> LogForm:
    """Form of a log by a file (TOML) that says which columns are which.

    time = "t [ms]"
    time_unit = "ms"              # s, ms, us, ns, or a format of dates: "%H:%M:%S.%f"
    motor_angle = ["q1", "q2"]    # or "q{}": as many as there are
    angle_unit = "deg"            # or rad
    reference = ["r1", "r2"]      # optional

    Raises InputError for keys and values that are not allowed.
    """
    with reading(check_file(file)):
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    if unknown := sorted(set(content) - {*TEXTS, *NAMES}):
        allowed = ", ".join((*TEXTS, *NAMES))
        raise InputError(f"{file.name}: unknown key {unknown[0]}. Keys: {allowed}")
    if absent := [key for key in NEEDED if key not in content]:
        raise InputError(f"{file.name} lacks the key {absent[0]}")
    given: dict[str, Any] = {"time_unit": None, "angle_unit": None, "reference": ()}
    for key, value in content.items():
        given[key] = _checked(file, key, value)
    with reading(file):
        return LogForm(name=f"columns of {file.name}", **given)


def _checked(file: Path, key: str, value: Any) -> str | tuple[str, ...]:
    if isinstance(value, str) and value:
        return value
    listed = isinstance(value, list) and all(isinstance(name, str) and name for name in value)
    if key in NAMES and listed and value:
        return tuple(str(name) for name in value)
    wanted = "a text" if key in TEXTS else "a text with {} or a list of texts"
    raise InputError(f"{file.name}: {key} must be {wanted}, got {value!r}")
