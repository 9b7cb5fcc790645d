"""A controller's log as a table: time [s], motor_angle_1.. and reference_1.. [rad].

Its form says which columns hold time, angles and reference, and their units.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from armside.arrays import Array, check_recorded_time
from armside.kinematics.robot_file import toml_of

from ...records.files import LARGEST_DATA, InputError, check_file, reading
from ...records.tables import table_of
from .columns import Diadem, TextTable, read_diadem, read_text

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
        for said, known in (("time_unit", TIMES), ("angle_unit", ANGLES)):
            unit = getattr(self, said)
            date = known is TIMES and DATE in (unit or "")
            if unit is not None and unit.lower() not in known and not date:
                raise ValueError(f"{said} must be one of {', '.join(known)}, got {unit!r}")
        if isinstance(self.reference, tuple) and isinstance(self.motor_angle, tuple):
            n, own = len(self.motor_angle), len(self.reference)
            if own not in (0, n):
                raise ValueError(f"reference must name {n} columns as motor_angle, got {own}")

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
        content = toml_of(file.read_bytes())
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


SUFFIXES = (".csv", ".txt", ".tsv", ".log", ".dat")
FAR = 1e5
"""[s] Stamps beyond count from the first one: dates, and counters of controllers."""
LARGEST = 1e3
"""[rad] Angle that no axis has."""
LOST = 0.2
"""Fraction of the rows that may lack a number."""


@dataclass(frozen=True, eq=False)
class ControllerLog:
    """Log of a controller as a table, with units."""

    table: pa.Table
    form: str
    notes: tuple[str, ...]


def read_log(file: Path, columns: Path | None = None) -> ControllerLog:
    """Table of a log whose form is known by its header, or by a file of columns; or InputError."""
    check_file(file, LARGEST_DATA)
    source = read_diadem(file) if file.suffix.lower() == ".dat" else read_text(file)
    form = _known(source) if columns is None else read_columns(columns)
    motors, references = form.motors(source.header), form.references(source.header)
    if absent := [name for name in (form.time, *motors, *references) if name not in source.header]:
        listed = ", ".join(source.header[:30])
        raise InputError(f"{file.name} has no column {absent[0]}. Columns: {listed}")
    if not motors:
        raise InputError(f"{file.name} has no columns {form.motor_angle}")
    names = (*motors, *references)
    units = [_factor(source, name, form.angle_unit, ANGLES, "angle_unit") for name in names]
    angles, time = source.numbers(names) * np.array(units), _time(source, form)
    whole = np.isfinite(time) & np.isfinite(angles).all(axis=1)
    _check(file, time, angles, whole)
    notes = [f"{file.name}: {form.name}, {len(motors)} axes"]
    if lost := int((~whole).sum()):
        notes.append(f"{file.name}: {lost} rows without a number are left out")
    written = [f"motor_angle_{i + 1}" for i in range(len(motors))]
    written += [f"reference_{i + 1}" for i in range(len(references))]
    found = {name: ("rad", own) for name, own in zip(written, angles[whole].T, strict=True)}
    table = table_of({"time": ("s", time[whole]), **found})
    return ControllerLog(table, form.name, tuple(notes))


def _known(source: TextTable | Diadem) -> LogForm:
    for form in FORMS:
        if form.time in source.header and form.motors(source.header):
            return form
    listed, known = ", ".join(source.written[:8]), ", ".join(dict.fromkeys(f.name for f in FORMS))
    text = f"is no log of a known form (columns {listed}; known: {known})"
    raise InputError(f"{source.file.name} {text}: say which columns are which by --columns FILE")


def _factor(
    source: TextTable | Diadem, name: str, unit: str | None, known: dict[str, float], key: str
) -> float:
    """[SI] of the unit of a column: that of the form, or of the header."""
    stated = source.units.get(name, "") if unit is None else unit
    if stated.strip().lower() not in known:
        given = repr(stated) if stated else "none"
        text = f"the unit of {name} must be one of {', '.join(known)}, the header has {given}"
        raise InputError(f"{source.file.name}: {text}; a file for --columns may state {key}")
    return known[stated.strip().lower()]


def _time(source: TextTable | Diadem, form: LogForm) -> Array:
    """(N,) [s], from the first stamp where they are far from zero."""
    unit = form.time_unit
    if unit is not None and DATE in unit:
        dates = [_date(source.file, cell, unit) for cell in source.texts(form.time)]
        return np.array([(date - dates[0]).total_seconds() for date in dates])
    factor = _factor(source, form.time, unit, TIMES, "time_unit")
    time = source.numbers((form.time,))[:, 0]
    first = time[np.isfinite(time)][:1]
    if first.size and abs(factor * first[0]) > FAR:
        time = time - first[0]
    return factor * time


def _date(file: Path, cell: str, form: str) -> datetime:
    try:
        return datetime.strptime(cell, form).replace(tzinfo=UTC)
    except ValueError:
        raise InputError(f"{file.name}: {cell[:40]!r} is no date of the form {form}") from None


def _check(file: Path, time: Array, angles: Array, whole: NDArray[np.bool_]) -> None:
    if len(time) < 2 or (~whole).mean() > LOST:
        given = f"{int((~whole).sum())} of {len(time)} rows lack a number"
        raise InputError(f"{file.name}: {given}; at least 2 rows are needed")
    if (largest := float(np.abs(angles[whole]).max())) > LARGEST:
        text = f"angles reach {largest:.3g} rad, at most {LARGEST:g} can be right"
        raise InputError(f"{file.name}: {text}: are the units as stated?")
    with reading(file):
        check_recorded_time(file.name, time[whole], np.flatnonzero(whole), gap=np.inf, repeats=True)
