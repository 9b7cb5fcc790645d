"""Tables of a robot file that describe hardware: read, and refused with field and what is allowed.

`TABLES` names them; `armside.sim.robot_file.hardware` has the keys of drives, gears and effects.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from armside.kinematics.dh import check_unit
from armside.kinematics.equations.inertial_model import nearest_inertia
from armside.kinematics.robot_file import numbers as parsed
from armside.kinematics.robot_file import refuse_unknown

from ..robot.drives import N_HARMONICS
from .hardware import (
    DRIVES,
    EACH,
    EFFECTS,
    GEARS,
    NEEDED,
    PHASES,
    Hardware,
    Key,
    LinkBody,
    StructureHinge,
    Values,
    Vector,
)
from .masses import Six, matrix

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


TABLES = ("hardware", "base", "body", "drives", "gears", "structure", "effects", "tool")
_WHOLE = ("mass", "time_step")
_BODY = ("mass", "centre", "inertia")
_HINGE = ("name", "link", "direction", "point", "stiffness", "damping", "damping_ratio")
STRUCTURE_DAMPING = 0.01
"""Damping ratio of a structure hinge by default: 1-2 % on the large robot. ESTIMATE."""
_SLACK = 1e-9  # relative rounding below the triangle inequality


def read_hardware(data: Mapping[str, Any], n_axes: int) -> Hardware:
    """Hardware of the tables of a robot file. Raises ValueError with table and key."""
    whole = table("hardware", data.get("hardware", {}), _WHOLE)
    gears = dict(table("gears", data.get("gears", {}), (*GEARS, "rigid")))
    rigid = gears.pop("rigid", False)
    if not isinstance(rigid, bool):
        raise ValueError(f"gears: rigid must be true or false, got {rigid!r}")
    springs = _values("gears", gears, GEARS, n_axes)
    effects = _values("effects", data.get("effects", {}), EFFECTS, n_axes)
    for name, other in (("stiffness", "frequency"), ("damping", "damping_ratio")):
        if name in springs and other in springs:
            raise ValueError(f"gears: give {name} or {other}, not both")
    for name, size in NEEDED.items():  # an effect is absent without its size
        if name in effects and size not in effects:
            raise ValueError(f"effects: {name} needs {size}")
    if rigid and "lost_motion" in effects:
        raise ValueError("effects: lost_motion needs gears with springs, got gears: rigid = true")
    bodies = tables("body", data.get("body", []))
    if bodies and len(bodies) != n_axes:
        n = len(bodies)
        raise ValueError(f"body must be {n_axes} tables, one for each moving link, got {n}")
    found = dict[str, Any]()
    if "mass" in whole:
        found["mass"] = scalar("hardware: mass", whole["mass"], "kg")
    if "time_step" in whole:
        found["timestep"] = scalar("hardware: time_step", whole["time_step"], "s", high=0.004)
    return Hardware(
        **found,
        base=_body("base", data.get("base", {})),
        bodies=tuple(_body(f"body {i}", row) for i, row in enumerate(bodies, 1)),
        tool=_body("tool", data.get("tool", {})),
        drives=_values("drives", data.get("drives", {}), DRIVES, n_axes),
        gears=springs,
        rigid=rigid,
        effects=effects,
        structure=_structure(data.get("structure", []), n_axes),
    )


def _body(where: str, row: Any) -> LinkBody:
    row = table(where, row, _BODY)
    mass = scalar(f"{where}: mass", row["mass"], "kg") if "mass" in row else None
    centre = vector3(f"{where}: centre", row["centre"], "m") if "centre" in row else None
    inertia = _inertia(f"{where}: inertia", row["inertia"]) if "inertia" in row else None
    return LinkBody(mass=mass, centre=centre, inertia=inertia)


def _inertia(where: str, value: Any) -> Six:
    """xx, yy, zz, xy, xz, yz [kg m^2] of three or six numbers of a file, which some body has."""
    if isinstance(value, list) and len(value) == 3:
        value = [*value, 0, 0, 0]
    if not isinstance(value, list) or len(value) != 6:
        raise ValueError(f"{where} must be 3 or 6 numbers: xx, yy, zz, xy, xz, yz, got {value!r}")
    six = vector(where, value, 6, "kg m^2")
    low, middle, high = np.linalg.eigvalsh(matrix(six)).tolist()  # pyright: ignore
    if low <= 0.0 or high > (low + middle) * (1.0 + _SLACK):
        raise ValueError(
            f"{where} must have principal moments above 0 of which none exceeds the sum of the "
            f"other two, got {low:.4g}, {middle:.4g}, {high:.4g}; the nearest: "
            f"{nearest_inertia(six)}"
        )
    return six  # pyright: ignore[reportReturnType] - the size is checked


def _values(where: str, given: Any, keys: Mapping[str, Key], n_axes: int) -> Values:
    given, found = table(where, given, tuple(keys)), dict[str, tuple[float, ...]]()
    for name, value in given.items():
        found[name] = _numbers(f"{where}: {name}", value, keys[name], n_axes)
        for one in found[name]:
            check_unit(f"{where}: {name}", name, one)
    return found


def _numbers(where: str, value: Any, key: Key, n_axes: int) -> tuple[float, ...]:
    size = {EACH: n_axes, PHASES: n_axes * N_HARMONICS}.get(key.size, key.size)
    listed = value if isinstance(value, list) else [value] * (n_axes if key.size == EACH else 1)
    if len(listed) != size:
        one = " or one number" if key.size == EACH and n_axes > 1 else ""
        raise ValueError(f"{where} must have {size} numbers{one}, got {len(listed)}")
    for one in listed:
        if key is DRIVES["gear_ratio"] and _is_number(one) and one < 0.0:
            against = f"a motor that turns against its axis has {-one:g} here, -1 in coupling"
            raise ValueError(f"{where} must be a finite number > 0, got {one:g}; {against}")
    return tuple(
        scalar(where, one, key.unit, key.low, strict=key.strict, high=key.high) for one in listed
    )


def _structure(rows: Any, n_axes: int) -> tuple[StructureHinge, ...]:
    found = [
        _hinge(f"structure {i}", row, n_axes) for i, row in enumerate(tables("structure", rows), 1)
    ]
    names = [hinge.name for hinge in found]
    if twice := {name for name in names if names.count(name) > 1}:
        raise ValueError(f"structure: name {min(twice)!r} is there twice")
    return tuple(found)


def _hinge(where: str, row: Any, n_axes: int) -> StructureHinge:
    row = table(where, row, _HINGE)
    needs(where, row, ("name", "link", "direction", "stiffness"))
    name, link = row["name"], row["link"]
    if not (isinstance(name, str) and name.isidentifier()):
        raise ValueError(f"{where}: name must be letters, digits and _, got {name!r}")
    if isinstance(link, bool) or not isinstance(link, int) or not 0 <= link <= n_axes:
        raise ValueError(f"{where}: link must be 0 (base) to {n_axes}, got {link!r}")
    direction = vector3(f"{where}: direction", row["direction"], "")
    if not any(direction):
        raise ValueError(f"{where}: direction must not be zero, got {list(direction)}")
    damped = scalar(f"{where}: damping", row["damping"], "N m s/rad") if "damping" in row else None
    ratio = row.get("damping_ratio", STRUCTURE_DAMPING)
    return StructureHinge(
        name=name,
        link=link,
        direction=direction,
        point=vector3(f"{where}: point", row.get("point", [0, 0, 0]), "m"),
        stiffness=scalar(f"{where}: stiffness", row["stiffness"], "N m/rad"),
        damping=damped,
        damping_ratio=scalar(f"{where}: damping_ratio", ratio, ""),
    )


def needs(where: str, row: Mapping[str, Any], names: Sequence[str]) -> None:
    """Raise ValueError for keys that a table lacks."""
    if missing := [name for name in names if name not in row]:
        raise ValueError(f"{where} lacks {', '.join(missing)}")
