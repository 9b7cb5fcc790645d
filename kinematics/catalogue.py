"""Robots by name: those of the thesis, and those that public measurements exist of."""

from collections.abc import Mapping
from pathlib import Path

from .measured_arms import AUBO_I5, AUBO_I5_LIMITS, IRB120, IRB120_LIMITS, UR10, UR10_LIMITS
from .robot_file import Arm, read_robot
from .robots import IRB1400, IRB1400_IMU, IRB1400_LIMITS, LARGE_ROBOT, LARGE_ROBOT_LIMITS
from .urdf import read_urdf

CATALOGUE: Mapping[str, Arm] = {
    "irb1400": Arm(IRB1400, IRB1400_LIMITS),
    "irb1400-imu": Arm(IRB1400_IMU, IRB1400_LIMITS),
    "large": Arm(LARGE_ROBOT, LARGE_ROBOT_LIMITS),
    "ur10": Arm(UR10, UR10_LIMITS),
    "irb120": Arm(IRB120, IRB120_LIMITS),
    "aubo_i5": Arm(AUBO_I5, AUBO_I5_LIMITS),
}
"""Robot and limits by the name of the command line."""


def find_arm(name: str) -> Arm:
    """Robot of a name of the catalogue, or of a robot file (TOML or URDF).

    Of a URDF file that is a tree, FILE.urdf#TIP or FILE.urdf#BASE:TIP is the chain to a tip link.

    Raises:
        ValueError: neither; the message has the names that exist.
        OSError: the file cannot be read.
    """
    if name in CATALOGUE:
        return CATALOGUE[name]
    if name.endswith(".toml"):
        return read_robot(Path(name))
    file, _, links = name.partition("#")
    if file.endswith(".urdf"):
        base, _, tip = links.rpartition(":")
        arm = read_urdf(Path(file), base or None, tip or None)
        return Arm(arm.robot, arm.limits)
    names = ", ".join(CATALOGUE)
    raise ValueError(f"Unknown robot {name!r}. It can be: {names}, or a robot file (.toml, .urdf)")
