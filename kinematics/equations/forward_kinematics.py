"""Pose, Jacobian and acceleration of the tool as straight-line programs of the motor angles."""

from dataclasses import replace

import sympy as sp

from ..dh import Joint, Robot
from ..expressions.exact import Expression, exact
from .chain import ZERO, Chain, Vector, added, crossed, joint_variables, scaled, walk
from .derivative import tangent
from .program import Block, Program, Tape


def motor_symbols(robot: Robot, suffix: str = "") -> tuple[sp.Symbol, ...]:
    """phi1..phin; with suffix "d" or "dd" their rates and accelerations."""
    return tuple(sp.Symbol(f"phi{suffix}{i}", real=True) for i in range(1, robot.n_joints + 1))


def notes(robot: Robot) -> tuple[str, ...]:
    """What every generated function says about its robot."""
    return (
        f"robot: {robot.name}; {robot.convention.value} Denavit-Hartenberg convention",
        "phi: motor angles on the arm side of the gear [rad]; joint variables = coupling phi + "
        "offset",
        f"coupling: {robot.coupling.tolist()}",
        f"offset: {robot.offset.tolist()}",
        "SI units; six-vectors are (v, omega) in base axes",
    )


def _phi(robot: Robot, name: str, suffix: str = "") -> Block:
    return Block(name, (robot.n_joints,), motor_symbols(robot, suffix))


def parameter_block(robot: Robot) -> list[Block]:
    """The symbols among the D-H parameters as one more input; nothing for a robot of numbers."""
    symbols = tuple(sorted(robot.free_symbols, key=str))
    return [Block("parameters", (len(symbols),), symbols)] if symbols else []


def _walk(robot: Robot, tape: Tape) -> Chain:
    return walk(robot, joint_variables(robot, motor_symbols(robot)), tape)


def pose(robot: Robot) -> Program:
    """T_base_tool, 4 x 4. Thesis (3.26)."""
    tape = Tape()
    chain = _walk(robot, tape)
    p = ZERO
    for arm in (*(axis.arm for axis in chain.axes), chain.tool_arm):
        p = added(tape, p, arm)
    x, y, z = chain.rotation
    rows = [e for i in range(3) for e in (x[i], y[i], z[i], p[i])] + [0, 0, 0, 1]
    out = Block("T", (4, 4), tuple(map(sp.sympify, rows)))
    inputs = [_phi(robot, "phi"), *parameter_block(robot)]
    return tape.program("pose", inputs, [out], notes(robot))


def jacobian_columns(chain: Chain, tape: Tape) -> list[tuple[Vector, Vector]]:
    """(v, omega) of the tool for each joint variable at unit rate. Thesis (3.46), (3.51)."""
    columns = []
    to_tool = chain.tool_arm
    for axis in reversed(chain.axes):
        if axis.joint is Joint.REVOLUTE:
            columns.append((crossed(tape, axis.direction, to_tool), axis.direction))
        else:
            columns.append((axis.direction, ZERO))
        to_tool = added(tape, axis.arm, to_tool)
    return columns[::-1]


def _coupled(
    robot: Robot, tape: Tape, columns: list[tuple[Expression, ...]]
) -> list[list[Expression]]:
    """J_phi = J_theta coupling, as columns. Thesis (4.10) differentiated."""
    n = len(columns)
    weights = [[exact(robot.coupling[i, j]) for j in range(n)] for i in range(n)]
    return [
        [tape(sp.Add(*(columns[i][row] * weights[i][j] for i in range(n)))) for row in range(6)]
        for j in range(n)
    ]


def jacobian(robot: Robot) -> Program:
    """J, 6 x n: (v, omega) of the tool origin in base axes from motor rates. Thesis (3.39)."""
    tape = Tape()
    columns = [(*v, *w) for v, w in jacobian_columns(_walk(robot, tape), tape)]
    coupled = _coupled(robot, tape, columns)
    elements = tuple(column[row] for row in range(6) for column in coupled)
    out = Block("J", (6, robot.n_joints), elements)
    return tape.program(
        "jacobian", [_phi(robot, "phi"), *parameter_block(robot)], [out], notes(robot)
    )


def jacobian_rate(robot: Robot) -> Program:
    """dJ/dt, 6 x n, from motor angles and their rates. Thesis (4.5)."""
    program = tangent(jacobian(robot), {"phi": "phi_dot"})
    return replace(
        program, name="jacobian_rate", outputs=(program.outputs[0]._replace(name="J_dot"),)
    )


def _swept(tape: Tape, omega: Vector, alpha: Vector, arm: Vector) -> Vector:
    """alpha x arm + omega x (omega x arm)."""
    inner = crossed(tape, omega, arm)
    return added(tape, crossed(tape, alpha, arm), crossed(tape, omega, inner))


def acceleration(robot: Robot) -> Program:
    """Classical (v_dot, omega_dot) of the tool origin in base axes. Thesis (3.57)."""
    tape = Tape()
    chain = _walk(robot, tape)
    linear = robot_rates(robot, tape, "d"), robot_rates(robot, tape, "dd")
    omega, alpha, a = ZERO, ZERO, ZERO
    for axis, rate, rate_dot in zip(chain.axes, *linear, strict=True):
        z = axis.direction
        a = added(tape, a, _swept(tape, omega, alpha, axis.arm))
        turning = crossed(tape, omega, z)
        if axis.joint is Joint.REVOLUTE:
            alpha = added(tape, alpha, scaled(tape, rate_dot, z))
            alpha = added(tape, alpha, scaled(tape, rate, turning))
            omega = added(tape, omega, scaled(tape, rate, z))
        else:
            a = added(tape, a, scaled(tape, rate_dot, z))
            a = added(tape, a, scaled(tape, 2 * rate, turning))
    a = added(tape, a, _swept(tape, omega, alpha, chain.tool_arm))
    inputs = [_phi(robot, "phi"), _phi(robot, "phi_dot", "d"), _phi(robot, "phi_ddot", "dd")]
    inputs += parameter_block(robot)
    out = Block("a", (6,), (*a, *alpha))
    return tape.program("acceleration", inputs, [out], notes(robot))


def robot_rates(robot: Robot, tape: Tape, suffix: str) -> list[Expression]:
    """Rates of the joint variables: coupling times motor rates."""
    symbols = motor_symbols(robot, suffix)
    constant = joint_variables(robot, (sp.S.Zero,) * robot.n_joints)
    moved = joint_variables(robot, symbols)
    return [tape(q - q0) for q, q0 in zip(moved, constant, strict=True)]
