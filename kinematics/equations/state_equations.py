"""State equations x' = f(x, tau) of a robot: rigid joints, or a spring in every joint. F01, K12.

Rigid: x = (phi, phi_dot). Flexible: x = (phi_arm, phi_motor, phi_arm_dot, phi_motor_dot), all as
motor angles on the arm side of the gear:

    D phi_a'' + C phi_a' + g = k (phi_m - phi_a) + d (phi_m' - phi_a')
    J phi_m'' + f(phi_m') + k (phi_m - phi_a) + d (phi_m' - phi_a') = tau

which is thesis (2.18) with its signs put right, in each joint of the robot. D here is without
rotor inertia, which belongs to the motors' own equation.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from ..expressions.exact import Expression, exact
from .composite import solved
from .derivative import tangent
from .dynamics import (
    blocks,
    forward_dynamics,
    friction,
    model_notes,
    motor_mass_matrix,
    motor_torques,
)
from .inertial_model import Motor, RobotModel
from .program import Block, Program, Tape


def rigid_rate(model: RobotModel) -> Program:
    """x'(x, tau) with x = (phi, phi_dot), shape (2 n,)."""
    program = forward_dynamics(model)
    phi, phi_dot, tau = program.inputs[:3]
    x = Block("x", (2 * len(phi.elements),), phi.elements + phi_dot.elements)
    rate = Block("x_dot", x.shape, phi_dot.elements + program.outputs[0].elements)
    inputs = (x, tau, *program.inputs[3:])
    told = (*program.notes, "x: motor angles, their rates")
    return replace(program, name="rigid_rate", inputs=inputs, outputs=(rate,), notes=told)


def flexible_rate(model: RobotModel) -> Program:
    """x'(x, tau) with x = (phi_arm, phi_motor, their rates), shape (4 n,).

    Raises:
        ValueError: a motor has no stiffness or no inertia.
    """
    n = model.robot.n_joints
    for number, motor in enumerate(model.motors, 1):
        if motor.stiffness is None or motor.inertia == 0:
            raise ValueError(f"motor {number} needs a stiffness and an inertia, got {motor}")
    tape = Tape()
    arm, arm_rate = (block.elements for block in blocks(model, "phi", "phi_dot")[:2])
    motor_angle = tuple(sp.Symbol(f"psi{i}", real=True) for i in range(1, n + 1))
    motor_rate = tuple(sp.Symbol(f"psid{i}", real=True) for i in range(1, n + 1))
    tau = blocks(model, "tau")[0]
    spring = spring_torques(model, tape, (arm, motor_angle, arm_rate, motor_rate))
    arm_acceleration = _arm_acceleration(model, tape, arm_rate, spring)
    lost = friction(model, tape, motor_rate)
    motor_acceleration = [
        tape((t - f - s) / exact(motor.inertia))
        for t, f, s, motor in zip(tau.elements, lost, spring, model.motors, strict=True)
    ]
    x = Block("x", (4 * n,), (*arm, *motor_angle, *arm_rate, *motor_rate))
    rate = (*arm_rate, *motor_rate, *arm_acceleration, *motor_acceleration)
    told = (*model_notes(model), "x: arm angles (as motor angles), motor angles, and their rates")
    inputs = [x, tau, *blocks(model, "phi")[1:]]
    return tape.program("flexible_rate", inputs, [Block("x_dot", (4 * n,), rate)], told)


def spring_torques(model: RobotModel, tape: Tape, state: Sequence[Any]) -> list[Expression]:
    """k (phi_m - phi_a) + d (phi_m' - phi_a'), each gear, arm side."""
    return [
        tape(exact(motor.stiffness) * (m - a) + exact(motor.damping) * (md - ad))
        for motor, a, m, ad, md in zip(model.motors, *state, strict=True)
    ]


def _arm_acceleration(
    model: RobotModel, tape: Tape, rates: Sequence[Any], torque: Sequence[Any]
) -> list[Expression]:
    """The arm alone, without its motors."""
    alone = replace(model, motors=(Motor(),) * model.robot.n_joints)
    bias = motor_torques(alone, tape, rates, [sp.S.Zero] * len(rates))
    right = [tape(t - b) for t, b in zip(torque, bias, strict=True)]
    return solved(tape, motor_mass_matrix(alone, tape), right)


def rate_tangent(program: Program) -> Program:
    """Directional derivative of a state equation along x_change, for Jacobians column by column."""
    return replace(tangent(program, {"x": "x_change"}), name=f"{program.name}_tangent")
