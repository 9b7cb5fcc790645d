"""State equations x' = f(x, tau) of a robot: rigid joints, or a spring in every joint. F01, K12.

Rigid: x = (phi, phi_dot). Flexible: x = (phi_arm, phi_motor, phi_arm_dot, phi_motor_dot), all as
motor angles on the arm side of the gear:

    D phi_a'' + C phi_a' + g = k (phi_m - phi_a) + d (phi_m' - phi_a')
    J phi_m'' + f(phi_m') + k (phi_m - phi_a) + d (phi_m' - phi_a') = tau

which is thesis (2.18) with its signs corrected, in each joint of the robot. D here is without
rotor inertia, which belongs to the motors' own equation.
"""

from dataclasses import replace

import sympy as sp

from ..expressions.symbols import exact
from .composite import solved
from .derivative import tangent
from .dynamics import (
    forward_dynamics,
    friction,
    frictionless_torques,
    inputs_of,
    motor_mass_matrix,
    notes,
)
from .inertial_model import InertialModel, Motor
from .program import Argument, StraightLineProgram, Tape, separated


def rigid_rate(model: InertialModel) -> StraightLineProgram:
    """x'(x, tau) with x = (phi, phi_dot), shape (2 n,)."""
    program = forward_dynamics(model)
    phi, phi_dot, tau = program.inputs[:3]
    x = Argument("x", (2 * len(phi.elements),), phi.elements + phi_dot.elements)
    rate = Argument("x_dot", x.shape, phi_dot.elements + program.outputs[0].elements)
    inputs = (x, tau, *program.inputs[3:])
    lines = (*program.notes, "x: motor angles, their rates")
    return replace(program, name="rigid_rate", inputs=inputs, outputs=(rate,), notes=lines)


@separated
def flexible_rate(model: InertialModel) -> StraightLineProgram:
    """x'(x, tau) with x = (phi_arm, phi_motor, their rates), shape (4 n,).

    Raises ValueError where a motor has no stiffness or no inertia.
    """
    n = model.robot.n_joints
    for number, motor in enumerate(model.motors, 1):
        if motor.stiffness is None or motor.inertia == 0:
            raise ValueError(f"motor {number} needs a stiffness and an inertia, got {motor}")
    tape = Tape()
    phi, phi_dot, tau, *parameters = inputs_of(model, "phi", "phi_dot", "tau")
    arm, arm_rate = phi.elements, phi_dot.elements
    motor_angle = tuple(sp.Symbol(f"psi{i}", real=True) for i in range(1, n + 1))
    motor_rate = tuple(sp.Symbol(f"psid{i}", real=True) for i in range(1, n + 1))
    state = zip(model.motors, arm, motor_angle, arm_rate, motor_rate, strict=True)
    spring = [
        tape(exact(motor.stiffness) * (m - a) + exact(motor.damping) * (md - ad))
        for motor, a, m, ad, md in state
    ]
    alone = replace(model, motors=(Motor(),) * n)  # the arm without its motors
    bias = frictionless_torques(alone, tape, arm_rate, [sp.S.Zero] * n)
    right = [tape(s - b) for s, b in zip(spring, bias, strict=True)]
    arm_acceleration = solved(tape, motor_mass_matrix(alone, tape), right)
    losses = friction(model, tape, motor_rate)
    motor_acceleration = [
        tape((t - f - s) / exact(motor.inertia))
        for t, f, s, motor in zip(tau.elements, losses, spring, model.motors, strict=True)
    ]
    x = Argument("x", (4 * n,), (*arm, *motor_angle, *arm_rate, *motor_rate))
    rate = (*arm_rate, *motor_rate, *arm_acceleration, *motor_acceleration)
    lines = (*notes(model), "x: arm angles (as motor angles), motor angles, and their rates")
    out = Argument("x_dot", (4 * n,), rate)
    return tape.program("flexible_rate", [x, tau, *parameters], [out], lines)


def rate_tangent(program: StraightLineProgram) -> StraightLineProgram:
    """Directional derivative of a state equation along x_change, for Jacobians column by column."""
    return replace(tangent(program, {"x": "x_change"}), name=f"{program.name}_tangent")
