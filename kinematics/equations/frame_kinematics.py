"""Pose and Jacobian of the frame of any link, in the axes of any frame, as straight-line programs.

Frames are counted as links are: 0 is the base, 1 to the number of links the frames after them.
"""

import sympy as sp

from ..dh import Robot
from ..expressions.exact import exact
from .chain import Chain, joint_axes
from .coupling import joint_variables, motor_inputs, motor_symbols, notes
from .forward_kinematics import columns, transform
from .program import Argument, StraightLineProgram, Tape
from .separate import separated
from .vectors import ZERO, Vector


@separated
def frame_pose(robot: Robot, frame: int) -> StraightLineProgram:
    """T_base_frame, 4 x 4. Thesis (3.22)."""
    tape = Tape()
    chain, _ = _chain(robot, frame, tape)
    out = transform(chain, tape)
    return tape.program("frame_pose", motor_inputs(robot, "phi"), [out], notes(robot))


@separated
def frame_jacobian(robot: Robot, frame: int, axes: int = 0) -> StraightLineProgram:
    """J, 6 x n: (v, omega) of the origin of a frame from motor rates, in the axes of another."""
    tape = Tape()
    chain, moving = _chain(robot, frame, tape)
    rotation = _chain(robot, axes, tape)[0].rotation
    turned = [
        (*_seen(tape, rotation, v), *_seen(tape, rotation, w)) for v, w in columns(chain, tape)
    ]
    weights = [[exact(k) for k in column[:moving]] for column in robot.coupling.T]
    elements = tuple(
        tape(sp.Add(*(column[i] * k for column, k in zip(turned, weight, strict=True))))
        for i in range(6)
        for weight in weights
    )
    out = Argument("J", (6, robot.n_joints), elements)
    lines = (*notes(robot), f"J: of the origin of frame {frame}, in the axes of frame {axes}")
    return tape.program("frame_jacobian", motor_inputs(robot, "phi"), [out], lines)


def _chain(robot: Robot, frame: int, tape: Tape) -> tuple[Chain, int]:
    """The chain from the base to a frame, and the number of its joints."""
    if isinstance(frame, bool) or not isinstance(frame, int) or not 0 <= frame <= len(robot.links):
        raise ValueError(f"frame must be 0 to {len(robot.links)} for {robot.name}, got {frame!r}")
    if frame == 0:
        x, y, z = (tuple(row) for row in sp.eye(3).tolist())
        return Chain((), ZERO, (x, y, z)), 0
    part = Robot(robot.links[:frame], convention=robot.convention)
    variables = joint_variables(robot, motor_symbols(robot))
    return joint_axes(part, variables[: part.n_joints], tape), part.n_joints


def _seen(tape: Tape, rotation: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    """Coordinates of v along the axes of a frame."""
    x, y, z = (tape(sp.Add(*(tape(a * b) for a, b in zip(e, v, strict=True)))) for e in rotation)
    return x, y, z
