"""Numbers of a robot file, each checked with the name of its field."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from armside.kinematics.robot_file import numbers as parsed
from armside.kinematics.robot_file import refuse_unknown

from .description import Vector

LARGEST = 1e12


def table(where: str, value: Any, allowed: Sequence[str]) -> Mapping[str, Any]:
    """A table with known keys alone. Raises ValueError with its name."""
    if not isinstance(value, dict):
        raise ValueError(f"{where} must be a table, got {value!r}")
    refuse_unknown(where, value, allowed)
    return value


def tables(name: str, value: Any) -> list[Any]:
    """Tables [[name]]. Raises ValueError for anything else."""
    if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
        raise ValueError(f"{name} must be tables [[{name}]], got {value!r}")
    return value


def scalar(
    where: str, value: Any, unit: str, low: float = 0.0, *, strict: bool = True, high: float = 1e12
) -> float:
    """One number in a range. Raises ValueError with the name of the field."""
    number = float(value) if _is_number(value) else parsed(where, [value])[0]
    inside = (number > low if strict else number >= low) and number <= high
    if not (math.isfinite(number) and inside):
        above = f"{'>' if strict else '>='} {low:g}"
        unsaid = high >= LARGEST and not (math.isfinite(number) and number > high)
        most = "" if unsaid else f" and <= {high:g}"
        unit = f" {unit}" if unit else ""
        raise ValueError(f"{where} must be a finite number {above}{most}{unit}, got {number:g}")
    return number


def vector(where: str, value: Any, size: int, unit: str) -> tuple[float, ...]:
    """Finite numbers of any sign. Raises ValueError with the name of the field."""
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"{where} must be a list of {size} numbers, got {value!r}")
    return tuple(scalar(where, one, unit, -LARGEST, strict=False) for one in value)


def vector3(where: str, value: Any, unit: str) -> Vector:
    """Three finite numbers. Raises as `vector`."""
    x, y, z = vector(where, value, 3, unit)
    return x, y, z


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
