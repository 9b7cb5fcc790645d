"""A controller's log as a table: time [s], motor_angle_1.. and reference_1.. [rad]."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from armside.arrays import Array

from ...records.files import LARGEST_DATA, InputError, check_file
from .form import ANGLES, DATE, FORMS, TIMES, LogForm, read_columns
from .tables import Diadem, TextTable, read_diadem, read_text

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
    """Table of a log whose form is known by its header, or by a file of columns.

    Raises:
        InputError: of no known form, columns or units that are missing, values that cannot be.
    """
    check_file(file, LARGEST_DATA)
    source = read_diadem(file) if file.suffix.lower() == ".dat" else read_text(file)
    form = _known(source) if columns is None else read_columns(columns)
    motors, references = form.motors(source.header), form.references(source.header)
    if absent := [n for n in (form.time, *motors, *references) if n not in source.header]:
        listed = ", ".join(source.header[:30])
        raise InputError(f"{file.name} has no column {absent[0]}. Columns: {listed}")
    if not motors:
        raise InputError(f"{file.name} has no columns {form.motor_angle}")
    angles = source.numbers((*motors, *references))
    angles = angles * np.array([_angle_unit(source, form, n) for n in (*motors, *references)])
    time = _time(source, form)
    whole = np.isfinite(time) & np.isfinite(angles).all(axis=1)
    _check(file, time, angles, whole)
    notes = [f"{file.name}: {form.name}, {len(motors)} axes"]
    if lost := int((~whole).sum()):
        notes.append(f"{file.name}: {lost} rows without a number are left out")
    return ControllerLog(_table(time[whole], angles[whole], len(motors)), form.name, tuple(notes))


def _known(source: TextTable | Diadem) -> LogForm:
    for form in FORMS:
        if form.fits(source.header):
            return form
    listed, known = ", ".join(source.written[:8]), ", ".join(dict.fromkeys(f.name for f in FORMS))
    text = f"is no log of a known form (columns {listed}; known: {known})"
    raise InputError(f"{source.file.name} {text}: say which columns are which by --columns FILE")


def _angle_unit(source: TextTable | Diadem, form: LogForm, name: str) -> float:
    return _factor(source, name, form.angle_unit, ANGLES, "angle_unit")


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
    if (back := np.diff(time[whole]) < 0.0).any():
        row = int(np.flatnonzero(whole)[int(np.argmax(back)) + 1]) + 1
        raise InputError(f"{file.name}: the clock runs backwards, first in row {row}")


def _table(time: Array, angles: Array, n: int) -> pa.Table:
    names = [f"motor_angle_{i}" for i in range(1, n + 1)]
    names += [f"reference_{i}" for i in range(1, angles.shape[1] - n + 1)]
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [pa.field(name, pa.float64(), metadata={"unit": "rad"}) for name in names]
    return pa.Table.from_arrays([pa.array(c) for c in (time, *angles.T)], schema=pa.schema(fields))
