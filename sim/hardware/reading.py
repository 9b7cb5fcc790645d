"""Tables of a robot file that describe hardware: read, and refused with field and what is allowed.

`TABLES` names them; `armside.sim.hardware.keys` has the keys of drives, gears and effects.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from .description import Hardware, LinkBody, StructureHinge, Values
from .inertia import checked_inertia
from .keys import DRIVES, EACH, EFFECTS, GEARS, NEEDED, PHASES, Key
from .numbers import scalar, table, tables, vector3

TABLES = ("hardware", "base", "body", "drives", "gears", "structure", "effects", "tool")
_WHOLE = ("mass", "time_step")
_BODY = ("mass", "centre", "inertia")
_HINGE = ("name", "link", "direction", "point", "stiffness", "damping", "damping_ratio")
STRUCTURE_DAMPING = 0.01
"""Damping ratio of a structure hinge by default: 1-2 % on the large robot. ESTIMATE."""
_N_HARMONICS = 4


def read_hardware(data: Mapping[str, Any], n_axes: int) -> Hardware:
    """Hardware of the tables of a robot file.

    Raises:
        ValueError: a wrong table; the message names table and key, and what is allowed.
    """
    whole = table("hardware", data.get("hardware", {}), _WHOLE)
    gears = dict(table("gears", data.get("gears", {}), (*GEARS, "rigid")))
    rigid = gears.pop("rigid", False)
    if not isinstance(rigid, bool):
        raise ValueError(f"gears: rigid must be true or false, got {rigid!r}")
    springs = _values("gears", gears, GEARS, n_axes)
    effects = _values("effects", data.get("effects", {}), EFFECTS, n_axes)
    _not_both(springs)
    _not_alone(effects)
    if rigid and "lost_motion" in effects:
        raise ValueError("effects: lost_motion needs gears with springs, got gears: rigid = true")
    return Hardware(
        **_whole(whole),
        base=_body("base", data.get("base", {})),
        bodies=_bodies(data.get("body", []), n_axes),
        tool=_body("tool", data.get("tool", {})),
        drives=_values("drives", data.get("drives", {}), DRIVES, n_axes),
        gears=springs,
        rigid=rigid,
        effects=effects,
        structure=_structure(data.get("structure", []), n_axes),
    )


def _whole(given: Mapping[str, Any]) -> dict[str, Any]:
    found = dict[str, Any]()
    if "mass" in given:
        found["mass"] = scalar("hardware: mass", given["mass"], "kg")
    if "time_step" in given:
        found["timestep"] = scalar("hardware: time_step", given["time_step"], "s", high=0.004)
    return found


def _bodies(rows: Any, n_axes: int) -> tuple[LinkBody, ...]:
    rows = tables("body", rows)
    if rows and len(rows) != n_axes:
        raise ValueError(f"body must be {n_axes} tables, one for each moving link, got {len(rows)}")
    return tuple(_body(f"body {i}", row) for i, row in enumerate(rows, 1))


def _body(where: str, row: Any) -> LinkBody:
    row = table(where, row, _BODY)
    mass = scalar(f"{where}: mass", row["mass"], "kg") if "mass" in row else None
    centre = vector3(f"{where}: centre", row["centre"], "m") if "centre" in row else None
    inertia = checked_inertia(f"{where}: inertia", row["inertia"]) if "inertia" in row else None
    return LinkBody(mass=mass, centre=centre, inertia=inertia)


def _values(where: str, given: Any, keys: Mapping[str, Key], n_axes: int) -> Values:
    given = table(where, given, tuple(keys))
    return {
        name: _numbers(f"{where}: {name}", value, keys[name], n_axes)
        for name, value in given.items()
    }


def _numbers(where: str, value: Any, key: Key, n_axes: int) -> tuple[float, ...]:
    size = {EACH: n_axes, PHASES: n_axes * _N_HARMONICS}.get(key.size, key.size)
    listed = value if isinstance(value, list) else [value] * (n_axes if key.size == EACH else 1)
    if len(listed) != size:
        one = " or one number" if key.size == EACH and n_axes > 1 else ""
        raise ValueError(f"{where} must have {size} numbers{one}, got {len(listed)}")
    return tuple(
        scalar(where, one, key.unit, key.low, strict=key.strict, high=key.high) for one in listed
    )


def _not_both(gears: Values) -> None:
    for name, other in (("stiffness", "frequency"), ("damping", "damping_ratio")):
        if name in gears and other in gears:
            raise ValueError(f"gears: give {name} or {other}, not both")


def _not_alone(effects: Values) -> None:
    """An effect is absent without its size, and what else is said of it would be without effect."""
    for name, size in NEEDED.items():
        if name in effects and size not in effects:
            raise ValueError(f"effects: {name} needs {size}")


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
    _needs(where, row, ("name", "link", "direction", "stiffness"))
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


def _needs(where: str, row: Mapping[str, Any], names: Sequence[str]) -> None:
    if missing := [name for name in names if name not in row]:
        raise ValueError(f"{where} lacks {', '.join(missing)}")
