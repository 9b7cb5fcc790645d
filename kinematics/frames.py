"""Compiled pose and Jacobian of the frame of any link of a robot of numbers."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .compiled import AngleFunction, refuse_symbols
from .dh import Robot
from .native_function import native_function, native_module

if TYPE_CHECKING:
    from .equations.program import StraightLineProgram


def compile_frame_pose(
    robot: Robot, frame: int, *, cache: Path | str | None = None
) -> AngleFunction:
    """pose(phi): T_base_frame, shape (4, 4). Thesis (3.22).

    frame: 0 is the base, k the frame of the k-th link, constant links counted.

    Raises ValueError for another frame, or a symbolic parameter.
    """

    def program() -> "StraightLineProgram":
        from .equations.frame_kinematics import frame_pose

        return frame_pose(robot, frame)

    return _compiled(robot, f"frame_pose_{frame}", (4, 4), program, cache)


def compile_frame_jacobian(
    robot: Robot, frame: int, axes: int = 0, *, cache: Path | str | None = None
) -> AngleFunction:
    """jacobian(phi): shape (6, n), (v, omega) of the origin of a frame for motor rates.

    frame: 0 is the base, k the frame of the k-th link, constant links counted.
    axes: frame whose axes v and omega are in; the base's by default, the frame's own if equal.

    Raises ValueError for another frame, or a symbolic parameter.
    """

    def program() -> "StraightLineProgram":
        from .equations.frame_kinematics import frame_jacobian

        return frame_jacobian(robot, frame, axes)

    shape = (6, robot.n_joints)
    return _compiled(robot, f"frame_jacobian_{frame}_{axes}", shape, program, cache)


def _compiled(
    robot: Robot, name: str, shape: tuple[int, ...], program: Any, cache: Path | str | None
) -> AngleFunction:
    refuse_symbols("compile", robot.name, robot.free_symbols)
    module = native_module(name, robot.key, program, cache)
    return native_function(module, (robot.n_joints,), shape)
