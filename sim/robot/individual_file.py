"""Robot individuals on disk: the parameters of `Individual` in TOML.

docs/formats.md has all parameters and the keys of `[[hidden]]`, a table for each hidden hinge.
Parameters that are left out are those of the design.
"""

from collections.abc import Collection, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array
from armside.kinematics.robot_file import refuse_unknown, toml_of

from .individual import NOT_NUMBERS, HiddenHinge, Individual

LARGEST = 100_000
"""Bytes of a file; all parameters need five thousand."""
FACTORS = (0.01, 100.0)
"""Range of a factor. ESTIMATE: beyond it is another robot."""
RANGES: Mapping[str, tuple[float, float, str]] = {
    **dict.fromkeys(("ripple_phase", "gear_error_phase"), (-100.0, 100.0, " rad")),
    "centre_of_mass": (-0.5, 0.5, " m"),
    "position": (-0.1, 0.1, " m"),
    "orientation": (-0.1, 0.1, " rad"),
}
"""Lowest and highest value with its unit, of parameters that are no factors. ESTIMATES."""
_HINGE = {
    "axis": (-1e3, 1e3, ""),
    "position": (-10.0, 10.0, " m"),
    "stiffness": (1e3, 1e10, " N m/rad"),
    "damping": (0.0, 1e8, " N m s/rad"),
}
PARAMETERS = tuple(field.name for field in fields(Individual) if field.name not in NOT_NUMBERS)


def read_individual(file: Path) -> Individual:
    """Individual of a file. Raises ValueError with file and field for a wrong one."""
    if not file.is_file():
        raise ValueError(f"{file} is no file; an individual is a number >= 0 or a TOML file")
    with file.open("rb") as content:
        text = content.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise ValueError(f"{file.name}: a file of an individual has at most {LARGEST} bytes")
    try:
        data = toml_of(text)
        refuse_unknown("the file", data, (*PARAMETERS, "hidden"))
        values: dict[str, Any] = {
            name: _within(name, value, *RANGES.get(name, (*FACTORS, "")))
            for name, value in data.items()
            if name != "hidden"
        }
        hinges = data.get("hidden", [])
        if not isinstance(hinges, list):
            raise ValueError(f"hidden must be tables [[hidden]], got {hinges!r}")
        hidden = tuple(_hinge(f"hidden hinge {i}", row) for i, row in enumerate(hinges, 1))
        return Individual(**values, hidden=hidden)
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise ValueError(f"{file.name}: {' '.join(str(error).split())}") from error


def individual_toml(individual: Individual) -> str:
    """Text of a file with every parameter of an individual; every number keeps its bits.

    Raises ValueError for an alien, whose effects no file has.
    """
    import tomlkit  # takes a tenth of a second, and few runs write a file

    if individual.alien:
        names = ", ".join(each.name for each in individual.alien)
        raise ValueError(f"an individual with the effects of an alien has no file: {names}")
    tables: dict[str, Any] = {n: np.asarray(getattr(individual, n)).tolist() for n in PARAMETERS}
    if individual.hidden:
        tables["hidden"] = [asdict(hinge) for hinge in individual.hidden]
    head = "# A robot individual: factors on its design, offsets in m and rad.\n"
    return head + tomlkit.dumps(tables)


def _hinge(where: str, row: Any) -> HiddenHinge:
    if not isinstance(row, dict):
        raise ValueError(f"{where} must be a table [[hidden]], got {row!r}")
    refuse_unknown(where, row, ("body", *_HINGE))
    if missing := [name for name in ("body", "axis", "stiffness", "damping") if name not in row]:
        raise ValueError(f"{where} lacks {', '.join(missing)}")
    numbers: dict[str, Any] = {
        name: _within(f"{where}: {name}", row[name], *limits)
        for name, limits in _HINGE.items()
        if name in row
    }
    try:
        return HiddenHinge(body=row["body"], **numbers)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{where}: {error}") from error


def _within(name: str, value: Any, low: float, high: float, unit: str) -> Array | float:
    """A number, or an array of numbers, all from `low` to `high`."""
    numbers = list(_leaves(value))
    if not numbers or not all(type(number) in (int, float) for number in numbers):
        raise ValueError(f"{name} must be numbers, got {value!r}"[:200])
    if outside := [number for number in numbers if not low <= number <= high]:
        raise ValueError(f"{name} must be from {low:g} to {high:g}{unit}, got {outside[0]!s:.40}")
    if not isinstance(value, list):
        return float(value)
    try:
        return np.array(value, dtype=np.float64)
    except ValueError:
        raise ValueError(f"{name} must be rows of equal length") from None


def _leaves(value: Any) -> Collection[Any]:
    return (
        [leaf for item in value for leaf in _leaves(item)] if isinstance(value, list) else [value]
    )
