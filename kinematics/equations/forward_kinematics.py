"""Pose, Jacobian and acceleration of the tool as straight-line programs of the motor angles.

So are pose and Jacobian of the frame of any link, in the axes of any frame. Frames are counted as
links are: 0 is the base, 1 to the number of links the frames after them.
"""

from dataclasses import replace

import sympy as sp

from ..dh import Joint, Robot
from ..expressions.symbols import exact
from .chain import ZERO, Chain, Vector, added, crossed, joint_axes, lever_acceleration, scaled
from .coupling import joint_rates, joint_variables, motor_inputs, motor_symbols, notes
from .derivative import tangent
from .program import Argument, StraightLineProgram, Tape, separated


def _chain(robot: Robot, tape: Tape) -> Chain:
    return joint_axes(robot, joint_variables(robot, motor_symbols(robot)), tape)


@separated
def pose(robot: Robot) -> StraightLineProgram:
    """T_base_tool, 4 x 4. Thesis (3.26)."""
    tape = Tape()
    out = transform(_chain(robot, tape), tape)
    return tape.program("pose", motor_inputs(robot, "phi"), [out], notes(robot))


def transform(chain: Chain, tape: Tape) -> Argument:
    """T, 4 x 4, from the base to the end of a chain."""
    p = ZERO
    for lever in (*(axis.lever for axis in chain.axes), chain.tool_lever):
        p = added(tape, p, lever)
    x, y, z = chain.rotation
    rows = [e for i in range(3) for e in (x[i], y[i], z[i], p[i])] + [0, 0, 0, 1]
    return Argument("T", (4, 4), tuple(map(sp.sympify, rows)))


def columns(chain: Chain, tape: Tape) -> list[tuple[Vector, Vector]]:
    """(v, omega) of the tool for each joint variable at unit rate. Thesis (3.46), (3.51)."""
    found = []
    to_tool = chain.tool_lever
    for axis in reversed(chain.axes):
        if axis.joint is Joint.REVOLUTE:
            found.append((crossed(tape, axis.direction, to_tool), axis.direction))
        else:
            found.append((axis.direction, ZERO))
        to_tool = added(tape, axis.lever, to_tool)
    return found[::-1]


@separated
def jacobian(robot: Robot) -> StraightLineProgram:
    """J, 6 x n: (v, omega) of the tool origin in base axes from motor rates. Thesis (3.39)."""
    tape = Tape()
    out = motor_jacobian(robot, _chain(robot, tape), tape)
    return tape.program("jacobian", motor_inputs(robot, "phi"), [out], notes(robot))


def motor_jacobian(robot: Robot, chain: Chain, tape: Tape) -> Argument:
    """J, 6 x n, of the motors of a robot with this chain."""
    six = [(*v, *w) for v, w in columns(chain, tape)]
    # J_phi = J_theta coupling, (4.10) differentiated
    weights = [[exact(k) for k in column] for column in robot.coupling.T]
    coupled = [
        [
            tape(sp.Add(*(e * k for e, k in zip(row, weight, strict=True))))
            for row in zip(*six, strict=True)
        ]
        for weight in weights
    ]
    elements = tuple(e for row in zip(*coupled, strict=True) for e in row)
    return Argument("J", (6, robot.n_joints), elements)


@separated
def pose_and_jacobian(robot: Robot) -> StraightLineProgram:
    """T_base_tool and J, row by row in one vector of 16 + 6 n."""
    tape = Tape()
    chain = _chain(robot, tape)
    parts = transform(chain, tape), motor_jacobian(robot, chain, tape)
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


@separated
def frame_pose(robot: Robot, frame: int) -> StraightLineProgram:
    """T_base_frame, 4 x 4. Thesis (3.22)."""
    tape = Tape()
    chain, _ = _frame_chain(robot, frame, tape)
    out = transform(chain, tape)
    return tape.program("frame_pose", motor_inputs(robot, "phi"), [out], notes(robot))


@separated
def frame_jacobian(robot: Robot, frame: int, axes: int = 0) -> StraightLineProgram:
    """J, 6 x n: (v, omega) of the origin of a frame from motor rates, in the axes of another."""
    tape = Tape()
    chain, moving = _frame_chain(robot, frame, tape)
    rotation = _frame_chain(robot, axes, tape)[0].rotation
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


def _frame_chain(robot: Robot, frame: int, tape: Tape) -> tuple[Chain, int]:
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
