"""Rigid-body dynamics as straight-line programs, by recursion over the links. Thesis (2.15).

    D(phi) phi'' + C(phi, phi') phi' + g(phi) + f(phi') = tau

in motor angles phi and motor torques tau on the arm side of the gear: with theta = M phi + theta0,
D = M^T D_theta M + diag(motor inertia), tau = M^T tau_theta + what the motors themselves need.
Nothing is expanded: each intermediate of the recursions keeps a name.
"""

from collections.abc import Sequence
from typing import Any

import sympy as sp

from ..dh import Joint
from ..expressions.exact import Expression, exact
from .chain import ZERO, Vector, added, crossed, joint_variables
from .composite import Matrix, joint_mass_matrix, solved
from .forward_kinematics import motor_symbols, notes
from .inertial_model import RobotModel
from .program import Block, Program, Tape
from .recursion import Inertia, State, Step, forward, steps, symbolic_inertias, tree


def model_notes(model: RobotModel) -> tuple[str, ...]:
    """Notes of a program that has torques in it."""
    gravity = [str(value) for value in model.gravity]
    return (
        *notes(model.robot),
        "tau: motor torques on the arm side of the gear [N m]",
        f"gravity: ({', '.join(gravity)}) m/s^2 in base axes",
    )


def blocks(model: RobotModel, *names: str) -> list[Block]:
    """Inputs by name (phi, phi_dot, phi_ddot, tau), and the symbolic parameters if any."""
    suffixes = {"phi": "", "phi_dot": "d", "phi_ddot": "dd"}
    n = model.robot.n_joints
    result = []
    for name in names:
        if name == "tau":
            symbols = tuple(sp.Symbol(f"tau{i}", real=True) for i in range(1, n + 1))
        else:
            symbols = motor_symbols(model.robot, suffixes[name])
        result.append(Block(name, (n,), symbols))
    parameters = tuple(sorted(model.free_symbols, key=str))
    if parameters:
        result.append(Block("parameters", (len(parameters),), parameters))
    return result


def coupled(model: RobotModel, tape: Tape, values: Sequence[Any]) -> list[Expression]:
    """Joint quantities from motor quantities: coupling times values."""
    return [
        tape(sp.Add(*(exact(k) * v for k, v in zip(row, values, strict=True) if k)))
        for row in model.robot.coupling
    ]


def transposed(model: RobotModel, tape: Tape, values: Sequence[Any]) -> list[Expression]:
    """Motor torques from joint torques: coupling^T times values."""
    return [
        tape(sp.Add(*(exact(k) * v for k, v in zip(column, values, strict=True) if k)))
        for column in model.robot.coupling.T
    ]


def _steps(model: RobotModel, tape: Tape) -> list[Step]:
    q = joint_variables(model.robot, motor_symbols(model.robot))
    return steps(tree(model.robot, model.bodies), q, tape)


def _tensor_times(tape: Tape, tensor: Sequence[Expression], v: Vector) -> Vector:
    xx, xy, xz, yy, yz, zz = tensor
    return (
        tape(xx * v[0] + xy * v[1] + xz * v[2]),
        tape(xy * v[0] + yy * v[1] + yz * v[2]),
        tape(xz * v[0] + yz * v[1] + zz * v[2]),
    )


def _wrench(tape: Tape, inertia: Inertia, state: State) -> tuple[Vector, Vector]:
    """Force and moment about the origin that make a body move so."""
    h, omega = inertia.moment, state.omega
    turning = added(
        tape,
        crossed(tape, state.alpha, h),
        crossed(tape, omega, crossed(tape, omega, h)),
    )
    force = tuple(tape(inertia.mass * a + w) for a, w in zip(state.a, turning, strict=True))
    moment = added(
        tape,
        _tensor_times(tape, inertia.tensor, state.alpha),
        crossed(tape, omega, _tensor_times(tape, inertia.tensor, omega)),
    )
    return (force[0], force[1], force[2]), added(tape, moment, crossed(tape, h, state.a))


def joint_torques(
    tape: Tape,
    chain: Sequence[Step],
    inertias: Sequence[Inertia],
    rates: Sequence[Any],
    accelerations: Sequence[Any],
    gravity: Sequence[Any],
) -> list[Expression]:
    """Torques of the joint variables by one pass out and one pass back (Newton-Euler)."""
    up = tuple(-exact(value) for value in gravity)
    states = forward(tape, chain, rates, accelerations, (up[0], up[1], up[2]))
    force, moment = ZERO, ZERO
    torques = []
    for i in reversed(range(len(chain))):
        own_force, own_moment = _wrench(tape, inertias[i], states[i])
        force, moment = added(tape, force, own_force), added(tape, moment, own_moment)
        revolute = chain[i].segment.joint is Joint.REVOLUTE
        torques.append(moment[2] if revolute else force[2])
        force = chain[i].out(tape, force)
        moment = added(tape, chain[i].out(tape, moment), crossed(tape, chain[i].shift, force))
    return torques[::-1]


def friction(model: RobotModel, tape: Tape, rates: Sequence[Any]) -> list[Expression]:
    """f(phi') = viscous phi' + coulomb sign(phi')."""
    return [
        tape(exact(motor.viscous) * rate + exact(motor.coulomb) * sp.sign(rate))
        for motor, rate in zip(model.motors, rates, strict=True)
    ]


def motor_torques(
    model: RobotModel,
    tape: Tape,
    rates: Sequence[Any],
    accelerations: Sequence[Any],
    gravity: Sequence[Any] | None = None,
    inertias: Sequence[Inertia] | None = None,
) -> list[Expression]:
    """All of (2.15) but friction, motor side of the coupling."""
    chain = _steps(model, tape)
    torques = joint_torques(
        tape,
        chain,
        inertias or [step.segment.inertia for step in chain],
        coupled(model, tape, rates),
        coupled(model, tape, accelerations),
        model.gravity if gravity is None else gravity,
    )
    return [
        tape(torque + exact(motor.inertia) * acceleration)
        for torque, motor, acceleration in zip(
            transposed(model, tape, torques), model.motors, accelerations, strict=True
        )
    ]


def inverse_dynamics(model: RobotModel) -> Program:
    """tau(phi, phi_dot, phi_ddot), friction included. Thesis (2.15)."""
    tape = Tape()
    inputs = blocks(model, "phi", "phi_dot", "phi_ddot")
    rates, accelerations = inputs[1].elements, inputs[2].elements
    torques = motor_torques(model, tape, rates, accelerations)
    total = [tape(u + v) for u, v in zip(torques, friction(model, tape, rates), strict=True)]
    return _program(model, tape, "inverse_dynamics", inputs, "tau", total)


def gravity_torque(model: RobotModel) -> Program:
    """g(phi). Thesis (2.15)."""
    tape = Tape()
    zeros = [sp.S.Zero] * model.robot.n_joints
    torques = motor_torques(model, tape, zeros, zeros)
    return _program(model, tape, "gravity_torque", blocks(model, "phi"), "g", torques)


def bias_torque(model: RobotModel) -> Program:
    """C(phi, phi_dot) phi_dot + g(phi) + f(phi_dot): (2.15) without its first term."""
    tape = Tape()
    inputs = blocks(model, "phi", "phi_dot")
    torques = _bias(model, tape, inputs[1].elements)
    return _program(model, tape, "bias_torque", inputs, "b", torques)


def _bias(model: RobotModel, tape: Tape, rates: Sequence[Any]) -> list[Expression]:
    zeros = [sp.S.Zero] * model.robot.n_joints
    torques = motor_torques(model, tape, rates, zeros)
    return [tape(u + v) for u, v in zip(torques, friction(model, tape, rates), strict=True)]


def motor_mass_matrix(model: RobotModel, tape: Tape) -> Matrix:
    """D = M^T D_theta M + diag(motor inertia)."""
    D = joint_mass_matrix(tape, _steps(model, tape))
    n = len(D)
    half = [transposed(model, tape, [D[i][j] for i in range(n)]) for j in range(n)]  # columns
    full = [transposed(model, tape, [half[j][i] for j in range(n)]) for i in range(n)]
    for i, motor in enumerate(model.motors):
        full[i][i] = tape(full[i][i] + exact(motor.inertia))
    return full


def mass_matrix(model: RobotModel) -> Program:
    """D(phi), n x n. Thesis (2.15)."""
    tape = Tape()
    D = motor_mass_matrix(model, tape)
    elements = [D[max(i, j)][min(i, j)] for i in range(len(D)) for j in range(len(D))]
    return _program(model, tape, "mass_matrix", blocks(model, "phi"), "D", elements, len(D))


def forward_dynamics(model: RobotModel) -> Program:
    """phi_ddot(phi, phi_dot, tau): (2.15) solved for the acceleration."""
    tape = Tape()
    inputs = blocks(model, "phi", "phi_dot", "tau")
    bias = _bias(model, tape, inputs[1].elements)
    right = [tape(t - b) for t, b in zip(inputs[2].elements, bias, strict=True)]
    x = solved(tape, motor_mass_matrix(model, tape), right)
    return _program(model, tape, "forward_dynamics", inputs, "phi_ddot", x)


def parametric_torque(model: RobotModel) -> Program:
    """tau without friction as a function also of Theta, ten parameters for each moving group:
    m, h (3), I about the body frame (Ixx, Ixy, Ixz, Iyy, Iyz, Izz). Linear in Theta: (2.17).
    """
    tape = Tape()
    inputs = blocks(model, "phi", "phi_dot", "phi_ddot")
    inertias = symbolic_inertias(model.robot.n_joints)
    theta = tuple(e for inertia in inertias for e in inertia.elements)
    torques = motor_torques(model, tape, inputs[1].elements, inputs[2].elements, inertias=inertias)
    motor = [exact(m.inertia) * a for m, a in zip(model.motors, inputs[2].elements, strict=True)]
    torques = [tape(t - m) for t, m in zip(torques, motor, strict=True)]
    inputs.insert(3, Block("theta", (len(theta),), theta))
    return _program(model, tape, "parametric_torque", inputs, "tau", torques)


def _program(
    model: RobotModel,
    tape: Tape,
    name: str,
    inputs: Sequence[Block],
    output: str,
    elements: Sequence[Expression],
    rows: int | None = None,
) -> Program:
    n = len(elements)
    shape = (n,) if rows is None else (rows, n // rows)
    return tape.program(name, inputs, [Block(output, shape, tuple(elements))], model_notes(model))
