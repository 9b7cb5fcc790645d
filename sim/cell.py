"""Robot cells: a robot with its limits, named tool poses and motion programs.

The large robot has the operating points of thesis chapter 9, the IRB1400 three of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from armside import assets, kinematics
from armside.arrays import Array
from armside.kinematics.rotation import to_quaternion


@dataclass(frozen=True)
class ToolPose:
    """Pose of the tool at the centre of a contour."""

    position: tuple[float, float, float]
    """[m], TCP0 in base axes."""
    quaternion: tuple[float, float, float, float]
    """Unit, base to tool."""

    @property
    def tool_axis(self) -> Array:
        """z axis of the tool in base axes, shape (3,)."""
        w, x, y, z = self.quaternion
        return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def tool_at(robot: kinematics.Robot, phi: ArrayLike) -> ToolPose:
    """Pose of the tool at motor angles phi (n,) [rad]."""
    T = kinematics.compile(robot).pose(np.array(phi, dtype=np.float64))
    w, a, b, c = to_quaternion(T[:3, :3]).tolist()
    x, y, z = T[:3, 3].tolist()
    return ToolPose((x, y, z), (w, a, b, c))


def _normalised(*q: float) -> tuple[float, float, float, float]:
    # (9.4) is printed with four decimals: its norm is 1.000004.
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    return float(w), float(x), float(y), float(z)


TOOL_QUATERNION = _normalised(0.6322, 0.0353, 0.7732, 0.0353)
"""Tool orientation in all experiments. Thesis (9.4)."""

LARGE_ROBOT_POSES = {
    "p1": ToolPose((1.3166, 0.0014, 1.5992), TOOL_QUATERNION),
    "p2": ToolPose((1.8000, 0.1000, 1.5992), TOOL_QUATERNION),
    "p3": ToolPose((2.2000, 0.2000, 1.5992), TOOL_QUATERNION),
}
"""TCP positions with respect to the robot base frame. Thesis (9.3)."""

_TO_THE_RIGHT = _normalised(0.4126, 0.1962, 0.8848, -0.0915)  # 40 deg down, 25 deg to the right
_TO_THE_LEFT = _normalised(0.4881, -0.1874, 0.8455, 0.1082)  # 30 deg down, 25 deg to the left

IRB1400_POSES = {
    "p1": ToolPose((0.5200, -0.1200, 1.1300), _TO_THE_RIGHT),
    "p2": ToolPose((1.2500, 0.1000, 1.1000), _TO_THE_LEFT),
    "p3": ToolPose((1.3000, 0.2500, 0.9500), _TO_THE_LEFT),
}
"""Near, far and stretched, within the reach of the IRB1400; the thesis has none. With these
orientations every motor moves: one that stays within its stiction cannot be improved."""


def pose(name: str, poses: Mapping[str, ToolPose] = LARGE_ROBOT_POSES) -> ToolPose:
    """Pose by name. Raises ValueError for an unknown name, with a list of those that exist."""
    if name not in poses:
        raise ValueError(f"Unknown pose {name!r}. Poses: {', '.join(poses)}")
    return poses[name]


@dataclass(frozen=True, kw_only=True)
class Learning:
    """Design variables of Q(u + gamma q^delta e) for all motors of a robot."""

    gamma: float
    delta: int
    """[samples]."""
    cutoff: float
    """[Hz]."""


@dataclass(frozen=True)
class Taken:
    """A number that a robot file does not give."""

    field: str
    values: tuple[float, ...]
    rule: str

    def __str__(self) -> str:
        shown = ", ".join(f"{value:.4g}" for value in self.values)
        return f"{self.field} = {shown}: {self.rule}"


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Robot type with its limits, poses and programs: data only."""

    xml: Path
    """MJCF of the virtual hardware."""
    robot: kinematics.Robot
    """Nominal D-H model of the controller."""
    with_imu: kinematics.Robot
    """D-H model with the IMU as its last frame."""
    limits: kinematics.Limits
    poses: Mapping[str, ToolPose]
    """Named poses of the tool."""
    programs: Mapping[str, tuple[Path, ...]]
    """Program files of each motion of the IMU experiment, by name."""
    home: tuple[float, ...] | None = None
    """Motor angles [rad] near which poses are reached; those of the zero pose if None."""
    free_rotation: bool = False
    """The tool's orientation is free: a contour sets its position alone."""
    learning: Learning | None = None
    """Default design of learning from motor angles; that of the thesis if None."""
    estimates: tuple[Taken, ...] = ()
    """Numbers of the hardware that a robot file without an MJCF leaves to estimates."""


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
    # From T_u as identified on this robot: `armside.sim.laser.design_from_data`.
    learning=Learning(gamma=1.0, delta=8, cutoff=20.0),
)
"""The IRB1400 of thesis chapter 5."""

CELLS: Mapping[str, Cell] = {"large": LARGE_CELL, "irb1400": IRB1400_CELL}
"""Cells by the name of their robot."""
