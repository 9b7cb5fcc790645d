"""Robots by name or file: a cell with its virtual hardware, or kinematics, limits and masses."""

from pathlib import Path
from typing import NamedTuple

from armside.kinematics import CATALOGUE, Arm, Body, read_robot, read_urdf
from armside.kinematics.urdf import UrdfArm

from ..cell import CELLS, Cell

_NO_MASSES = "The source has no masses, or some beside the chain move."


def find_cell(robot: str) -> Cell:
    """Cell of a name, or of a robot file. Raises ValueError with file and field, or OSError."""
    check_named(robot)
    return CELLS[robot] if robot in CELLS else read_cell(Path(robot))


def check_named(robot: str) -> None:
    """Raise ValueError for what is neither a robot's name nor a robot file's."""
    if robot not in CELLS and not robot.endswith(".toml"):
        known = ", ".join(CELLS)
        raise ValueError(f"Unknown robot {robot!r}. Robots: {known}, or a robot file (.toml)")


def read_cell(file: Path) -> Cell:
    """Cell of a robot file. Raises ValueError with file and field, or OSError."""
    from armside.kinematics.robot_file import read_toml

    from .cell_tables import cell_of

    return read_toml(file, lambda data: cell_of(data, file.parent))


def is_cell_file(name: str) -> bool:
    """True for a TOML file that has more than the kinematics of a robot."""
    from armside.kinematics.robot_file import OF_CELL, read_toml

    return name.endswith(".toml") and bool(read_toml(Path(name), lambda d: set(d) & set(OF_CELL)))


class KnownRobot(NamedTuple):
    """A robot with its limits, and the masses on its links where they are asked for and known."""

    arm: Arm
    bodies: tuple[Body, ...] = ()
    """One for each link."""
    notes: tuple[str, ...] = ()
    """Sentences on what the bodies leave out."""


def load_robot(name: str, *, masses: bool = False) -> KnownRobot:
    """Robot of a name, a robot file (TOML, with its virtual hardware or without), URDF or MJCF.

    A chain of a tree is FILE.urdf#TIP, FILE.urdf#BASE:TIP, and likewise of an MJCF.

    masses: of a robot with virtual hardware too, which are those of its MJCF, springs at rest.

    Raises:
        ValueError: none of these, or a wrong file; the message names file and element, or the names
            that exist.
        OSError: a file cannot be read.
    """
    file, _, links = name.partition("#")
    base, _, tip = links.rpartition(":")
    if masses and (name in CELLS or is_cell_file(name)):
        from ..robot.kinematics_check import cell_model
        from .mjcf_reader import serial_bodies

        cell = find_cell(name)
        found = serial_bodies(cell_model(cell), cell.robot)
        notes = (f"Left out, as no serial arm has it: {body}." for body in found.left_out)
        return KnownRobot(Arm(cell.robot, cell.limits), found.bodies, tuple(notes))
    if name in CATALOGUE:
        return KnownRobot(CATALOGUE[name])
    if name.endswith(".toml"):
        return KnownRobot(read_robot(Path(name)))
    if file.endswith(".urdf"):
        return _of_tree(read_urdf(Path(file), base or None, tip or None))
    if file.endswith(".xml"):
        from .mjcf_reader import read_mjcf

        return _of_tree(read_mjcf(Path(file), base or None, tip or None))
    known = f"{', '.join(CATALOGUE)}, or a robot file (.toml, .urdf, .xml)"
    raise ValueError(f"Unknown robot {name!r}. It can be: {known}")


def _of_tree(tree: UrdfArm) -> KnownRobot:
    arm = Arm(tree.robot, tree.limits)
    if tree.bodies is None:
        return KnownRobot(arm, notes=(_NO_MASSES,))
    return KnownRobot(arm, tree.bodies)
