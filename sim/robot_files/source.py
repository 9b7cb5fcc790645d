"""Robots that a new robot file is made from: geometry, limits and, where known, masses."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from armside.kinematics import Limits, Link, Robot
from armside.kinematics.robot_file import Arm
from armside.kinematics.urdf import read_urdf

from ..hardware.description import Hardware
from ..hardware.urdf_bodies import bodies_of
from ..named_robot import find_robot
from ..robot.mjcf_arm import read_mjcf


@dataclass(frozen=True)
class Source:
    """A robot and what is known of its hardware."""

    arm: Arm
    hardware: Hardware
    said: str
    """Where it comes from, for the file's first comment."""


def read_source(file: Path, tip: str | None = None) -> Source:
    """Robot of a URDF (.urdf), an MJCF (.xml) or a D-H table (.toml).

    tip: last link of a URDF, or last body or site of an MJCF; its only end if None.

    Raises:
        ValueError: another kind of file, or a wrong one; the message names it.
        OSError: it cannot be read.
    """
    if file.suffix in (".urdf", ".xml"):
        read, kind = (read_urdf, "URDF") if file.suffix == ".urdf" else (read_mjcf, "MJCF")
        arm = read(file, None, tip)
        hardware = Hardware(bodies=bodies_of(arm))
        return Source(Arm(arm.robot, arm.limits), hardware, f"{kind} {file.name}")
    if tip is not None:
        raise ValueError(f"tip chooses a chain of a URDF or MJCF, got {file.name}")
    if file.suffix == ".toml":
        return Source(find_robot(str(file)), Hardware(), f"D-H table of {file.name}")
    raise ValueError(f"source must be a .urdf, .xml (MJCF) or .toml (D-H table), got {file.name}")


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
