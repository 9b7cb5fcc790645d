"""A file (TOML) that says which columns of a log are which.

time = "t [ms]"
time_unit = "ms"              # s, ms, us, ns, or a format of dates: "%H:%M:%S.%f"
motor_angle = ["q1", "q2"]    # or "q{}": as many as there are
angle_unit = "deg"            # or rad
reference = ["r1", "r2"]      # optional
"""

import tomllib
from pathlib import Path
from typing import Any

from ...records.files import InputError, check_file, reading
from .form import LogForm

TEXTS = ("time", "time_unit", "angle_unit")
NAMES = ("motor_angle", "reference")
NEEDED = ("time", "motor_angle")


def read_columns(file: Path) -> LogForm:
    """Form of a log by a file. Raises InputError for keys and values that are not allowed."""
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
