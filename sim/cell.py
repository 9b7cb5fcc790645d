"""Robot cells: which robot, its kinematics and limits, and where it works."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
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
    with_imu: kinematics.Robot
    """The same down to the IMU."""
    limits: kinematics.Limits
    poses: Mapping[str, ToolPose]
    """Named poses of the tool."""
    programs: Mapping[str, tuple[Path, ...]]
    """Motions of the IMU experiment by name: the programs they consist of."""


_PROGRAMS = assets.IRB1400_XML.parent / "programs"


LARGE_CELL = Cell(
    xml=assets.LARGE_ROBOT_XML,
    robot=kinematics.LARGE_ROBOT,
    with_imu=replace(
        kinematics.LARGE_ROBOT,
        links=(*kinematics.LARGE_ROBOT.links, *kinematics.IMU_LINKS),
        name="LARGE_ROBOT with IMU",
    ),
    limits=kinematics.LARGE_ROBOT_LIMITS,
    poses=LARGE_ROBOT_POSES,
    programs={"simultaneous": (_PROGRAMS / "large_simultaneous.toml",)},
)
"""The large robot of thesis chapter 9."""

IRB1400_CELL = Cell(
    xml=assets.IRB1400_XML,
    robot=kinematics.IRB1400,
    with_imu=kinematics.IRB1400_IMU,
    limits=kinematics.IRB1400_LIMITS,
    poses=IRB1400_POSES,
    programs={
        "simultaneous": (_PROGRAMS / "irb1400_simultaneous.toml",),
        "sequential": (
            _PROGRAMS / "irb1400_sequential_arm.toml",
            _PROGRAMS / "irb1400_sequential_wrist.toml",
        ),
    },
)
"""The IRB1400 of thesis chapter 5."""

CELLS: Mapping[str, Cell] = {"large": LARGE_CELL, "irb1400": IRB1400_CELL}
"""Cells by the name of their robot."""
