"""Rigid-body dynamics as straight-line programs, by recursion over the links. Thesis (2.15).

    D(phi) phi'' + C(phi, phi') phi' + g(phi) + f(phi') = tau

in motor angles phi and motor torques tau on the arm side of the gear: with theta = M phi + theta0,
D = M^T D_theta M + diag(motor inertia), tau = M^T tau_theta + torque of the motors themselves.
Nothing is expanded: each intermediate of the recursions keeps a name.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from ..expressions.symbols import Expression, exact
from . import coupling
from .chain import ZERO, Matrix, Vector, added, crossed, symmetric, times
from .composite import joint_mass_matrix, solved
from .derivative import jacobian_of
from .inertial_model import InertialModel
from .program import Argument, StraightLineProgram, Tape, separated
from .recursion import (
    FrameMotion,
    Inertia,
    JointTransform,
    body_chain,
    forward,
    joint_transforms,
    symbolic_inertias,
)


def notes(model: InertialModel) -> tuple[str, ...]:
    """Notes of the robot, its torques and gravity, for the header of generated code."""
    return (
        *coupling.notes(model.robot),
        "tau: motor torques on the arm side of the gear [N m]",
        f"gravity: ({', '.join(map(str, model.gravity))}) m/s^2 in base axes",
    )


def inputs_of(model: InertialModel, *names: str) -> list[Argument]:
    """Inputs among phi, phi_dot, phi_ddot, tau, and the symbolic parameters if any."""
    return coupling.motor_inputs(model.robot, *names, symbols=model.free_symbols)


def joint_chain(model: InertialModel, tape: Tape) -> list[JointTransform]:
    """Joint transforms with the bodies of the model, at the symbols phi1..phin."""
    q = coupling.joint_variables(model.robot, coupling.motor_symbols(model.robot))
    return joint_transforms(body_chain(model.robot, model.bodies), q, tape)


def _wrench(tape: Tape, inertia: Inertia, motion: FrameMotion) -> tuple[Vector, Vector]:
    """Force and moment about the frame's origin that give a body its motion."""
    h, omega = inertia.moment, motion.omega
    tangential = crossed(tape, motion.alpha, h)
    h_ddot = added(tape, tangential, crossed(tape, omega, crossed(tape, omega, h)))
    force = tuple(tape(inertia.mass * a + w) for a, w in zip(motion.a, h_ddot, strict=True))
    tensor = symmetric(inertia.tensor)
    moment = times(tape, tensor, motion.alpha)
    gyroscopic = crossed(tape, omega, times(tape, tensor, omega))
    moment = added(tape, moment, gyroscopic)
    return (force[0], force[1], force[2]), added(tape, moment, crossed(tape, h, motion.a))


def newton_euler(
    tape: Tape,
    chain: Sequence[JointTransform],
    inertias: Sequence[Inertia],
    rates: Sequence[Any],
    accelerations: Sequence[Any],
    gravity: Sequence[Any],
) -> list[Expression]:
    """Torques of the joint variables by one pass outward and one inward."""
    up = tuple(-exact(value) for value in gravity)
    motions = forward(tape, chain, rates, accelerations, (up[0], up[1], up[2]))
    force, moment = ZERO, ZERO
    torques = []
    for joint, inertia, motion in reversed(list(zip(chain, inertias, motions, strict=True))):
        own_force, own_moment = _wrench(tape, inertia, motion)
        force, moment = added(tape, force, own_force), added(tape, moment, own_moment)
        torques.append(moment[2] if joint.revolute else force[2])
        force, moment = joint.out(tape, force), joint.out(tape, moment)
        moment = added(tape, moment, crossed(tape, joint.translation, force))
    return torques[::-1]


def friction(model: InertialModel, tape: Tape, rates: Sequence[Any]) -> list[Expression]:
    """f(phi') = viscous phi' + coulomb sign(phi')."""
    return [
        tape(exact(motor.viscous) * rate + exact(motor.coulomb) * sp.sign(rate))
        for motor, rate in zip(model.motors, rates, strict=True)
    ]


def frictionless_torques(
    model: InertialModel,
    tape: Tape,
    rates: Sequence[Any],
    accelerations: Sequence[Any],
    inertias: Sequence[Inertia] | None = None,
) -> list[Expression]:
    """Left side of (2.15) without friction; inertias of the bodies replaced if given."""
    chain = joint_chain(model, tape)
    inertias = inertias or [joint.segment.inertia for joint in chain]
    q_dot, q_ddot = (coupling.joint_rates(model.robot, tape, v) for v in (rates, accelerations))
    torques = newton_euler(tape, chain, inertias, q_dot, q_ddot, model.gravity)
    torques = coupling.motor_torques(model.robot, tape, torques)
    return [
        tape(torque + exact(motor.inertia) * acceleration)
        for torque, motor, acceleration in zip(torques, model.motors, accelerations, strict=True)
    ]


@separated
def inverse_dynamics(model: InertialModel) -> StraightLineProgram:
    """tau(phi, phi_dot, phi_ddot), friction included. Thesis (2.15)."""
    tape, inputs = Tape(), inputs_of(model, "phi", "phi_dot", "phi_ddot")
    tau = _with_friction(model, tape, inputs[1].elements, inputs[2].elements)
    return _program(model, tape, "inverse_dynamics", inputs, "tau", tau)


def _with_friction(
    model: InertialModel, tape: Tape, rates: Sequence[Any], accelerations: Sequence[Any]
) -> list[Expression]:
    torques = frictionless_torques(model, tape, rates, accelerations)
    return [tape(u + v) for u, v in zip(torques, friction(model, tape, rates), strict=True)]


@separated
def gravity_torque(model: InertialModel) -> StraightLineProgram:
    """g(phi). Thesis (2.15)."""
    tape, zeros = Tape(), [sp.S.Zero] * model.robot.n_joints
    torques = frictionless_torques(model, tape, zeros, zeros)
    return _program(model, tape, "gravity_torque", inputs_of(model, "phi"), "g", torques)


@separated
def bias_torque(model: InertialModel) -> StraightLineProgram:
    """C(phi, phi_dot) phi_dot + g(phi) + f(phi_dot): (2.15) without its first term."""
    tape, zeros = Tape(), [sp.S.Zero] * model.robot.n_joints
    inputs = inputs_of(model, "phi", "phi_dot")
    torques = _with_friction(model, tape, inputs[1].elements, zeros)
    return _program(model, tape, "bias_torque", inputs, "b", torques)


@separated
def coriolis_matrix(model: InertialModel) -> StraightLineProgram:
    """C(phi, phi_dot), n x n, with D' - 2 C skew (2.16).

    C phi_dot is quadratic in the rates and Christoffel symbols are symmetric in them, so that C is
    half its derivative by the rates.
    """
    tape, zeros = Tape(), [sp.S.Zero] * model.robot.n_joints
    inputs = inputs_of(model, "phi", "phi_dot")
    torques = frictionless_torques(model, tape, inputs[1].elements, zeros)
    program = jacobian_of(_program(model, tape, "", inputs, "", torques), ["phi_dot"])
    (H,) = program.outputs
    C = Argument("C", H.shape, tuple(element / 2 for element in H.elements))
    return replace(program, name="coriolis_matrix", outputs=(C,))


def motor_mass_matrix(model: InertialModel, tape: Tape) -> Matrix:
    """D = M^T D_theta M + diag(motor inertia)."""
    D = coupling.congruent(model.robot, tape, joint_mass_matrix(tape, joint_chain(model, tape)))
    for i, motor in enumerate(model.motors):
        D[i][i] = tape(D[i][i] + exact(motor.inertia))
    return D


@separated
def mass_matrix(model: InertialModel) -> StraightLineProgram:
    """D(phi), n x n. Thesis (2.15)."""
    D, n = motor_mass_matrix(model, tape := Tape()), model.robot.n_joints
    elements = tuple(D[max(i, j)][min(i, j)] for i in range(n) for j in range(n))
    out = Argument("D", (n, n), elements)
    return tape.program("mass_matrix", inputs_of(model, "phi"), [out], notes(model))


@separated
def forward_dynamics(model: InertialModel) -> StraightLineProgram:
    """phi_ddot(phi, phi_dot, tau): (2.15) solved for the acceleration."""
    tape, zeros = Tape(), [sp.S.Zero] * model.robot.n_joints
    inputs = inputs_of(model, "phi", "phi_dot", "tau")
    bias = _with_friction(model, tape, inputs[1].elements, zeros)
    right = [tape(t - b) for t, b in zip(inputs[2].elements, bias, strict=True)]
    x = solved(tape, motor_mass_matrix(model, tape), right)
    return _program(model, tape, "forward_dynamics", inputs, "phi_ddot", x)


@separated
def parametric_torque(model: InertialModel) -> StraightLineProgram:
    """tau without friction as a function also of Theta, ten parameters for each moving group:
    m, h (3), I about the body frame (Ixx, Ixy, Ixz, Iyy, Iyz, Izz). Linear in Theta: (2.17).
    """
    tape, inputs = Tape(), inputs_of(model, "phi", "phi_dot", "phi_ddot")
    inertias = symbolic_inertias(model.robot.n_joints)
    theta = tuple(e for inertia in inertias for e in inertia.elements)
    torques = frictionless_torques(model, tape, inputs[1].elements, inputs[2].elements, inertias)
    motor = [exact(m.inertia) * a for m, a in zip(model.motors, inputs[2].elements, strict=True)]
    torques = [tape(t - m) for t, m in zip(torques, motor, strict=True)]
    inputs.insert(3, Argument("theta", (len(theta),), theta))
    return _program(model, tape, "parametric_torque", inputs, "tau", torques)


def _program(
    model: InertialModel,
    tape: Tape,
    name: str,
    inputs: Sequence[Argument],
    output: str,
    torques: Sequence[Expression],
) -> StraightLineProgram:
    out = Argument(output, (len(torques),), tuple(torques))
    return tape.program(name, inputs, [out], notes(model))
