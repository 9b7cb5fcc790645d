"""Named poses of a cell: reached within the limits, and how near to a singularity."""

from dataclasses import dataclass

import numpy as np

from armside import kinematics
from armside.arrays import Array

from ..cell import Cell, ToolPose
from ..cut.tool_motion import joint_reference
from ..robot.kinematics_check import configurations
from .check import Check

LEAST_DEXTERITY = 0.005
"""Of a named pose. ESTIMATE: the poses of thesis (9.3), near a wrist singularity, have 0.016 and
more."""


@dataclass(frozen=True)
class NamedPose:
    """A named pose as the controller reaches it from the home pose."""

    name: str
    motor_angle: Array | None
    """(n,) [rad], arm side; None where it is not reached."""
    problem: str
    """Why it is not reached: reach, or axis and limit."""
    dexterity: float
    """Least over greatest singular value of the Jacobian of what a contour sets: the tool's pose,
    or its position where the orientation is free. 0 at a singularity, NaN where not reached."""


_ZERO = 1e-9
"""Singular values that count as none [m/rad]."""


@dataclass(frozen=True)
class _Still:
    position: Array
    quaternion: Array


def named_poses(cell: Cell) -> list[NamedPose]:
    """All poses of a cell, in the order of its file."""
    return [_found(cell, name, pose) for name, pose in cell.poses.items()]


def checks_of(found: list[NamedPose]) -> list[Check]:
    """Verdicts; each names the pose that is worst off."""
    missed = [one for one in found if one.motor_angle is None]
    what = "named poses out of reach or limits"
    if missed:
        what += f" ({missed[0].name}: {missed[0].problem})"
    checks = [Check("", what, "", float(len(missed)), high=0.0)]
    reached = [one for one in found if one.motor_angle is not None]
    if reached:
        worst = min(reached, key=lambda one: one.dexterity)
        far = f"least over greatest singular value of the Jacobian, pose {worst.name}"
        checks.append(Check("", far, "", worst.dexterity, low=LEAST_DEXTERITY))
    return checks


def _found(cell: Cell, name: str, pose: ToolPose) -> NamedPose:
    still = _Still(np.array([pose.position]), np.array([pose.quaternion]))
    free = cell.free_rotation
    try:
        (phi,) = joint_reference(
            still, cell.robot, cell.limits, start=cell.home, free_rotation=free
        )
    except ValueError as error:
        return NamedPose(name, None, str(error), float("nan"))
    return NamedPose(name, phi, "", _dexterity(cell, phi))


def _dexterity(cell: Cell, phi: Array) -> float:
    """Of the directions that the robot has in other configurations."""
    rows = slice(3) if cell.free_rotation else slice(6)
    jacobian = kinematics.compile(cell.robot).jacobian
    elsewhere = np.linalg.matrix_rank(jacobian(configurations(cell.limits))[:, rows], _ZERO)
    S = np.linalg.svd(jacobian(phi)[rows], compute_uv=False)
    return float(S[elsewhere.max() - 1] / S[0])
