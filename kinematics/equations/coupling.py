"""Motor quantities as inputs of programs, and their coupling to the joint variables.

Joint variables = coupling phi + offset, so rates and accelerations of the joints are the coupling
times those of the motors, and torques of the motors its transpose times those of the joints.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import sympy as sp

from armside.arrays import Array

from ..dh import Robot
from ..expressions.symbols import Expression, exact, exact_angle
from .chain import Matrix
from .program import Argument, Tape

_PREFIX = {"phi": "phi", "phi_dot": "phid", "phi_ddot": "phidd", "tau": "tau"}


def motor_symbols(robot: Robot, name: str = "phi") -> tuple[sp.Symbol, ...]:
    """phi1..phin; of phi_dot, phi_ddot and tau likewise phid1, phidd1 and tau1."""
    return tuple(sp.Symbol(f"{_PREFIX[name]}{i}", real=True) for i in range(1, robot.n_joints + 1))


def motor_inputs(robot: Robot, *names: str, symbols: Iterable[Any] = ()) -> list[Argument]:
    """Inputs among phi, phi_dot, phi_ddot, tau, and one of all symbolic parameters, if any.

    symbols: parameters besides the Denavit-Hartenberg parameters of the robot.
    """
    inputs = [Argument(name, (robot.n_joints,), motor_symbols(robot, name)) for name in names]
    parameters = tuple(sorted({*robot.free_symbols, *symbols}, key=lambda s: s.name))
    if parameters:
        inputs.append(Argument("parameters", (len(parameters),), parameters))
    return inputs


def notes(robot: Robot) -> tuple[str, ...]:
    """Robot, convention, coupling and units, for the header of generated code."""
    relation = "on the arm side of the gear; joint variables = coupling phi + offset"
    units = [f"phi: motor angles {relation.replace(';', ' [rad];')}"]
    if any(robot.slides):
        each = ", ".join("m" if slides else "rad" for slides in robot.slides)
        forces = "forces of prismatic joints [N], torques [N m]"
        units = [f"phi: motor variables {relation}", f"joint variables: [{each}]; {forces}"]
    return (
        f"robot: {robot.name}; {robot.convention.value} Denavit-Hartenberg convention",
        *units,
        f"coupling: {robot.coupling.tolist()}",
        f"offset: {robot.offset.tolist()}",
        "SI units; six-vectors are (v, omega) in base axes",
    )


def joint_variables(robot: Robot, phi: Sequence[Expression]) -> tuple[Expression, ...]:
    """coupling phi + offset, exact. Thesis (4.10)."""
    result = []
    for slides, row, constant in zip(robot.slides, robot.coupling, robot.offset, strict=True):
        offset = exact(constant) if slides else exact_angle(constant)
        result.append(sp.Add(offset, *_terms(row, phi)))
    return tuple(result)


def joint_rates(robot: Robot, tape: Tape, rates: Sequence[Any]) -> list[Expression]:
    """Rates or accelerations of the joint variables: coupling times those of the motors."""
    return [tape(sp.Add(*_terms(row, rates))) for row in robot.coupling]


def motor_torques(robot: Robot, tape: Tape, torques: Sequence[Any]) -> list[Expression]:
    """Motor torques from torques of the joint variables: coupling^T times them."""
    return [tape(sp.Add(*_terms(column, torques))) for column in robot.coupling.T]


def congruent(robot: Robot, tape: Tape, A: Matrix) -> Matrix:
    """coupling^T A coupling of a matrix of the joint variables."""
    columns = [motor_torques(robot, tape, column) for column in zip(*A, strict=True)]
    return [motor_torques(robot, tape, row) for row in zip(*columns, strict=True)]


def _terms(weights: Array, values: Sequence[Any]) -> list[Expression]:
    return [exact(k) * value for k, value in zip(weights, values, strict=True) if k]
