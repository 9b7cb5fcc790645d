"""A robot by name or file with its limits and the masses on its links, where they are known."""

from pathlib import Path
from typing import NamedTuple

from armside.kinematics import Arm, Body, UrdfArm, read_urdf

from .cell import CELLS
from .cell_file import find_cell, is_cell_file
from .named_robot import find_robot
from .robot.cell_model import cell_model
from .robot.mjcf_arm import read_mjcf
from .robot.serial_bodies import serial_bodies


class HeavyArm(NamedTuple):
    """A robot, its limits, and a body for each of its links; no bodies where none are known."""

    arm: Arm
    bodies: tuple[Body, ...] = ()
    notes: tuple[str, ...] = ()
    """Sentences on what the bodies leave out."""


def arm_with_masses(name: str) -> HeavyArm:
    """Robot of a name, a robot file, a URDF or an MJCF, with the masses that its source has.

    Of a robot with an MJCF of its own the masses are those of that file, springs at rest.

    Raises:
        ValueError: none of these, or a wrong file; the message names file and element.
        OSError: a file cannot be read.
    """
    file, _, links = name.partition("#")
    base, _, tip = links.rpartition(":")
    if file.endswith(".urdf"):
        return _of_tree(read_urdf(Path(file), base or None, tip or None))
    if file.endswith(".xml"):
        return _of_tree(read_mjcf(Path(file), base or None, tip or None))
    is_cell = name in CELLS or is_cell_file(name)
    return _of_cell(name) if is_cell else HeavyArm(find_robot(name))


def _of_tree(tree: UrdfArm) -> HeavyArm:
    arm = Arm(tree.robot, tree.limits)
    if tree.bodies is None:
        return HeavyArm(arm, notes=("The source has no masses, or some beside the chain move.",))
    return HeavyArm(arm, tree.bodies)


def _of_cell(name: str) -> HeavyArm:
    cell = find_cell(name)
    found = serial_bodies(cell_model(cell), cell.robot)
    notes = [f"Left out, as no serial arm has it: {body}." for body in found.left_out]
    return HeavyArm(Arm(cell.robot, cell.limits), found.bodies, tuple(notes))
