"""Robot cells: which robot, its kinematics and limits, and where it works."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import assets
import kinematics

from .motion.poses import IRB1400_POSES, LARGE_ROBOT_POSES, ToolPose


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One kind of robot at its place: data only."""

    xml: Path
    """MJCF of the virtual hardware."""
    robot: kinematics.Robot
    """Its D-H model, as the controller knows it."""
    limits: kinematics.Limits
    poses: Mapping[str, ToolPose]
    """Named poses of the tool."""


LARGE_CELL = Cell(
    xml=assets.LARGE_ROBOT_XML,
    robot=kinematics.LARGE_ROBOT,
    limits=kinematics.LARGE_ROBOT_LIMITS,
    poses=LARGE_ROBOT_POSES,
)
"""The large robot of thesis chapter 9."""

IRB1400_CELL = Cell(
    xml=assets.IRB1400_XML,
    robot=kinematics.IRB1400,
    limits=kinematics.IRB1400_LIMITS,
    poses=IRB1400_POSES,
)
"""The IRB1400 of thesis chapter 5."""

CELLS: Mapping[str, Cell] = {"large": LARGE_CELL, "irb1400": IRB1400_CELL}
"""Cells by the name of their robot."""
