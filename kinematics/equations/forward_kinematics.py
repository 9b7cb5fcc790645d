"""Pose, Jacobian and acceleration of the tool as straight-line programs of the motor angles.

So are pose and Jacobian of the frame of any link, in the axes of any frame. Frames are counted as
links are: 0 is the base, 1 to the number of links the frames after them.
"""

from dataclasses import replace

import sympy as sp

from ..dh import Joint, Robot
from ..expressions.symbols import Expression, exact
from .chain import ZERO, Chain, Vector, added, crossed, joint_axes, lever_acceleration, scaled
from .coupling import joint_rates, joint_variables, motor_inputs, motor_symbols, notes
from .derivative import tangent
from .program import Argument, StraightLineProgram, Tape, separated


@separated
def pose(robot: Robot, frame: int | None = None) -> StraightLineProgram:
    """T_base_frame, 4 x 4, of the tool by default. Thesis (3.22), (3.26)."""
    tape = Tape()
    out = _transform(_chain(robot, tape, frame), tape)
    return tape.program("pose", motor_inputs(robot, "phi"), [out], notes(robot))


@separated
def jacobian(robot: Robot, frame: int | None = None, axes: int = 0) -> StraightLineProgram:
    """J, 6 x n: (v, omega) of the origin of a frame from motor rates, in the axes of another.

    Thesis (3.39); by default of the tool in base axes.
    """
    tape = Tape()
    chain = _chain(robot, tape, frame)
    out = _motor_jacobian(robot, chain, tape, _chain(robot, tape, axes).rotation)
    lines = notes(robot)
    if frame is not None:
        lines = (*lines, f"J: of the origin of frame {frame}, in the axes of frame {axes}")
    return tape.program("jacobian", motor_inputs(robot, "phi"), [out], lines)


@separated
def pose_and_jacobian(robot: Robot) -> StraightLineProgram:
    """T_base_tool and J, row by row in one vector of 16 + 6 n."""
    tape = Tape()
    chain = _chain(robot, tape)
    base = _chain(robot, tape, 0).rotation
    parts = _transform(chain, tape), _motor_jacobian(robot, chain, tape, base)
    elements = tuple(e for part in parts for e in part.elements)
    out = Argument("T_and_J", (len(elements),), elements)
    return tape.program("pose_and_jacobian", motor_inputs(robot, "phi"), [out], notes(robot))


def jacobian_rate(robot: Robot) -> StraightLineProgram:
    """dJ/dt, 6 x n, from motor angles and their rates. Thesis (4.5)."""
    program = tangent(jacobian(robot), {"phi": "phi_dot"})
    out = program.outputs[0]._replace(name="J_dot")
    return replace(program, name="jacobian_rate", outputs=(out,))


@separated
def acceleration(robot: Robot) -> StraightLineProgram:
    """Classical (v_dot, omega_dot) of the tool origin in base axes. Thesis (3.57)."""
    tape = Tape()
    chain = _chain(robot, tape)
    rates = joint_rates(robot, tape, motor_symbols(robot, "phi_dot"))
    accelerations = joint_rates(robot, tape, motor_symbols(robot, "phi_ddot"))
    omega, alpha, a = ZERO, ZERO, ZERO
    for axis, rate, rate_dot in zip(chain.axes, rates, accelerations, strict=True):
        z = axis.direction
        a = added(tape, a, lever_acceleration(tape, omega, alpha, axis.lever))
        z_dot = crossed(tape, omega, z)
        if axis.joint is Joint.REVOLUTE:
            alpha = added(tape, alpha, scaled(tape, rate_dot, z))
            alpha = added(tape, alpha, scaled(tape, rate, z_dot))
            omega = added(tape, omega, scaled(tape, rate, z))
        else:
            a = added(tape, a, scaled(tape, rate_dot, z))
            a = added(tape, a, scaled(tape, 2 * rate, z_dot))
    a = added(tape, a, lever_acceleration(tape, omega, alpha, chain.tool_lever))
    inputs = motor_inputs(robot, "phi", "phi_dot", "phi_ddot")
    return tape.program("acceleration", inputs, [Argument("a", (6,), (*a, *alpha))], notes(robot))


def _chain(robot: Robot, tape: Tape, frame: int | None = None) -> Chain:
    """The chain from the base to a frame, the tool's by default."""
    most = len(robot.links)
    frame = most if frame is None else frame
    if isinstance(frame, bool) or not isinstance(frame, int) or not 0 <= frame <= most:
        raise ValueError(f"frame must be 0 to {most} for {robot.name}, got {frame!r}")
    variables = joint_variables(robot, motor_symbols(robot))
    return joint_axes(robot.links[:frame], robot.convention, variables, tape)


def _transform(chain: Chain, tape: Tape) -> Argument:
    """T, 4 x 4, from the base to the end of a chain."""
    p = ZERO
    for lever in (*(axis.lever for axis in chain.axes), chain.tool_lever):
        p = added(tape, p, lever)
    x, y, z = chain.rotation
    rows = [e for i in range(3) for e in (x[i], y[i], z[i], p[i])] + [0, 0, 0, 1]
    return Argument("T", (4, 4), tuple(map(sp.sympify, rows)))


def _motor_jacobian(
    robot: Robot, chain: Chain, tape: Tape, rotation: tuple[Vector, Vector, Vector]
) -> Argument:
    """J, 6 x n, of the end of a chain in the axes that are the columns of a rotation.

    Thesis (3.46), (3.51), and J_phi = J_theta coupling, (4.10) differentiated.
    """
    six, to_tool = list[list[Expression]](), chain.tool_lever
    for axis in reversed(chain.axes):
        v, w = axis.direction, ZERO
        if axis.joint is Joint.REVOLUTE:
            v, w = crossed(tape, axis.direction, to_tool), axis.direction
        six.append([*_seen(tape, rotation, v), *_seen(tape, rotation, w)])
        to_tool = added(tape, axis.lever, to_tool)
    rows = list(zip(*six[::-1], strict=True)) or [()] * 6
    columns = [
        [tape(sp.Add(*(e * exact(k) for e, k in zip(row, weight, strict=False)))) for row in rows]
        for weight in robot.coupling.T
    ]
    elements = tuple(e for row in zip(*columns, strict=True) for e in row)
    return Argument("J", (6, robot.n_joints), elements)


def _seen(tape: Tape, rotation: tuple[Vector, Vector, Vector], v: Vector) -> list[Expression]:
    """Coordinates of v along the axes of a frame."""
    return [tape(sp.Add(*(tape(a * b) for a, b in zip(e, v, strict=True)))) for e in rotation]
