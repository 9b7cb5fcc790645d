"""A new robot file, from a URDF, an MJCF, a D-H table or a template.

It has every table that a robot file may have: known numbers, and estimates as comments.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from tomlkit.items import Table

from armside.kinematics import Limits, Link, Robot
from armside.kinematics.robot_file import Arm, robot_tables
from armside.kinematics.urdf import UrdfArm, read_urdf

from ..cell import tool_at
from .build import Built, build
from .cell_tables import bent
from .find import load_robot
from .hardware import DRIVES, EFFECTS, GEARS, Hardware, Key, LinkBody
from .masses import bodies_of
from .mjcf_reader import read_mjcf
from .written import number

_Place = tomlkit.TOMLDocument | Table
_Value = str | float | Sequence[float]
_DECIMALS = 12


@dataclass(frozen=True)
class Source:
    """A robot and what is known of its hardware."""

    arm: Arm
    hardware: Hardware
    origin: str
    """Where it comes from, for the file's first comment."""
    assumed: str = ""
    """What the file it comes from does not say and is taken, in a sentence."""


def read_source(file: Path, tip: str | None = None) -> Source:
    """Robot of a URDF (.urdf), an MJCF (.xml) or a D-H table (.toml); ValueError for any other.

    tip: last link of a URDF, or last body or site of an MJCF; its only end if None.
    """
    if file.suffix in (".urdf", ".xml"):
        read, kind = (read_urdf, "URDF") if file.suffix == ".urdf" else (read_mjcf, "MJCF")
        arm = read(file, None, tip)
        hardware = Hardware(bodies=bodies_of(arm))
        assumed = without_speed(arm)
        return Source(Arm(arm.robot, arm.limits), hardware, f"{kind} {file.name}", assumed)
    if tip is not None:
        raise ValueError(f"tip chooses a chain of a URDF or MJCF, got {file.name}")
    if file.suffix == ".toml":
        return Source(load_robot(str(file)).arm, Hardware(), f"D-H table of {file.name}")
    raise ValueError(f"source must be a .urdf, .xml (MJCF) or .toml (D-H table), got {file.name}")


def without_speed(arm: UrdfArm) -> str:
    """Sentence on the joints whose greatest speed is assumed; empty if there are none."""
    if not arm.without_speed:
        return ""
    names = ", ".join(arm.without_speed)
    return f"speed of {names} is assumed: the file has 0 or none"


def template() -> Source:
    """A six-axis arm with a spherical wrist, reach about 1 m, to be overwritten."""
    half = np.pi / 2
    links = [
        Link(d=0.4, a=0.1, alpha=-half),
        Link(a=0.45),
        Link(a=0.05, alpha=-half),
        Link(d=0.45, alpha=half),
        Link(alpha=-half),
        Link(d=0.1),
    ]
    robot = Robot(links, offset=[0, -half, 0, 0, 0, np.pi], name="my robot")
    ends = np.deg2rad([170, 100, 120, 190, 120, 350])
    speed = np.deg2rad([180, 180, 180, 300, 300, 400])
    limits = Limits(lower=tuple(-ends), upper=tuple(ends), speed=tuple(speed))
    return Source(Arm(robot, limits), Hardware(), "template")


def commented(source: Source) -> str:
    """Text of a robot file. Raises ValueError for hardware that cannot be built."""
    robot, limits = source.arm
    home = bent(source.arm)
    built = build(robot, limits, source.hardware, home=home)
    tables = robot_tables(robot, limits, number)
    doc = tomlkit.document()
    defaults = "Numbers behind # are defaults: take the # away"
    _note(doc, f"Robot file, made from: {source.origin}. {defaults}")
    _note(
        doc, "to state another. `armside robot check FILE` lists each that is taken, with its rule."
    )
    links, ends = tables.pop("link"), tables.pop("limits")
    for name, value in tables.items():
        doc.add(name, value)
    _state(doc, "home", home, "motor angles near which poses are reached [rad or m]")
    _default(doc, "orientation", "held", 'or "free": contours set the tool\'s position alone')
    doc.add(tomlkit.nl())
    _note(doc, "D-H table, from the base [m], [rad]")
    doc.add("link", tomlkit.item(links))
    units = "[rad] and [rad/s]; [m] and [m/s] of a prismatic axis"
    doc.add("limits", _table(ends, f"{units}; {source.assumed}" if source.assumed else units))
    _add_masses(doc, source.hardware, built, robot.n_joints)
    _add_drives(doc, built)
    _add_pose(doc, robot, home)
    return tomlkit.dumps(doc)


def _note(table: _Place, text: str) -> None:
    table.add(tomlkit.comment(text))


def _state(table: _Place, name: str, value: _Value, note: str) -> None:
    """A key with a comment behind it."""
    stated = tomlkit.item(_shown(value))
    table.add(name, stated.comment(note))


def _default(table: _Place, name: str, value: _Value | None, note: str) -> None:
    """A key behind #, without a value where it has none."""
    text = "" if value is None else f"{tomlkit.item(_shown(value)).as_string()} "
    _note(table, f"{name} = {text}# {note}")


def _shown(value: _Value) -> Any:
    if isinstance(value, str):
        return value
    return number(value) if isinstance(value, int | float) else [number(one) for one in value]


def _table(values: Mapping[str, Any], note: str) -> Table:
    table = tomlkit.table()
    table.update(values)
    table.comment(note)
    return table


def _add_masses(doc: _Place, given: Hardware, built: Built, n: int) -> None:
    taken = {one.field: one for one in built.taken}
    hardware = tomlkit.table()
    whole, about = taken.get("hardware: mass"), "[kg] of the whole robot, tool excluded"
    value, rule = (whole.values[0], f". {whole.rule}") if whole else (None, "")
    _default(hardware, "mass", value, f"{about}{rule}")
    _default(hardware, "time_step", 0.0005, "[s]")
    hardware.add(tomlkit.nl())
    _note(hardware, "one for each moving link, in the axes of its D-H frame")
    masses = iter(taken["body: mass"].values if "body: mass" in taken else ())
    if not given.bodies:
        for mass in masses:
            hardware.add(tomlkit.nl())
            _note(hardware, "[[body]]")
            _default(hardware, "mass", mass, "[kg]")
    doc.add("hardware", hardware)
    if given.bodies:
        doc.add("body", tomlkit.aot())
    for body in given.bodies:
        doc["body"].append(_body(body, masses))
    tool = _table({}, "in the axes of the tool frame")
    for name, unit in (("mass", "[kg]"), ("centre", "[m]"), ("inertia", "[kg m^2]")):
        if (one := taken.get(f"tool: {name}")) is not None:
            value = one.values[0] if name == "mass" else one.values
            _default(tool, name, value, f"{unit}. {one.rule}")
    doc.add("tool", tool)


def _body(body: LinkBody, masses: Iterator[float]) -> Table:
    """Table of a link, whose mass is the next estimate where it has none."""
    table = tomlkit.table()
    if body.mass is None:
        _default(table, "mass", next(masses), "[kg]")
    else:
        _state(table, "mass", body.mass, "[kg]")
    for name, unit in (("centre", "[m]"), ("inertia", "xx yy zz xy xz yz [kg m^2]")):
        if (value := getattr(body, name)) is not None:
            _state(table, name, [round(v, _DECIMALS) for v in value], unit)
    return table


def _add_drives(doc: _Place, built: Built) -> None:
    """Tables of drives, gears and effects, each key with what it is when it is not given."""
    taken = {one.field: one.values for one in built.taken}
    for where, keys in (("drives", DRIVES), ("gears", GEARS)):
        table = _table({}, "arm side of the gear")
        for name, key in keys.items():
            values = taken.get(f"{where}: {name}")
            value = values[0] if values is not None and key.size == 1 else values
            rule = f"; {key.default}" if key.default else ""
            _default(table, name, value, f"{_unit(key)}{key.meaning}{rule}")
        doc.add(where, table)
    doc.add(tomlkit.nl())
    _note(doc, "[effects] # absent where they are not given")
    for name, key in EFFECTS.items():
        _default(doc, name, None, f"{_unit(key)}{key.meaning}; default: {key.default}")


def _unit(key: Key) -> str:
    return f"[{key.unit}] " if key.unit else ""


def _add_pose(doc: _Place, robot: Robot, home: tuple[float, ...]) -> None:
    at_home = tool_at(robot, home)
    pose = _table({}, "the tool at home")
    _state(pose, "position", [round(x, 6) for x in at_home.position], "[m]")
    quaternion = [round(x, 9) for x in at_home.quaternion]
    _state(pose, "quaternion", quaternion, "w first, base to tool")
    poses = tomlkit.table(is_super_table=True)
    poses.add("p1", pose)
    doc.add("pose", poses)
    doc.add(tomlkit.nl())
    _note(doc, "[learning] # design of learning from motor angles")
    for name, value, note in (
        ("gamma", 0.9, "gain"),
        ("delta", 3.0, "[samples of 4 ms]"),
        ("cutoff", 10.0, "[Hz]"),
    ):
        _default(doc, name, value, note)
