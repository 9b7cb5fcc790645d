"""Kinematics of a robot by name, or by a file of any of the kinds that are read."""

from pathlib import Path

from armside.kinematics.catalogue import CATALOGUE, find_arm
from armside.kinematics.robot_file import Arm


def find_robot(name: str) -> Arm:
    """Robot and limits as `find_arm` has them, of a cell's robot file, and of an MJCF.

    An MJCF is named as a URDF is: FILE.xml, FILE.xml#TIP, FILE.xml#BASE:TIP.

    Raises as `find_arm`, `read_cell` and `read_mjcf`.
    """
    model, _, links = name.partition("#")
    if name in CATALOGUE or not model.endswith((".xml", ".toml")):
        return find_arm(name)
    if model.endswith(".xml"):
        from .robot.mjcf_arm import read_mjcf

        base, _, tip = links.rpartition(":")
        arm = read_mjcf(Path(model), base or None, tip or None)
        return Arm(arm.robot, arm.limits)
    from .cell_file import is_cell_file, read_cell  # virtual hardware, which takes time to load

    if is_cell_file(name):
        cell = read_cell(Path(name))
        return Arm(cell.robot, cell.limits)
    return find_arm(name)
