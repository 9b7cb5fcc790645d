"""Dynamics of small robots as full symbolic matrices, by energies and Christoffel symbols.

Thesis (2.15), (2.16). Independent of the recursions of `equations.dynamics` and much slower: for
one to three joints.
"""

from dataclasses import dataclass
from typing import Any

import sympy as sp

from ..equations.chain import symmetric
from ..equations.coupling import motor_symbols
from ..equations.inertial_model import InertialModel
from ..equations.recursion import simplified_constant
from ..expressions.symbols import Expression, SymbolicMatrix, exact
from .procedures import angular_jacobian, at, exact_coupling, matrix_t


@dataclass(frozen=True)
class SymbolicDynamics:
    """D phi'' + C phi' + g + f = tau in motor angles."""

    phi: tuple[sp.Symbol, ...]
    phi_dot: tuple[sp.Symbol, ...]
    D: SymbolicMatrix
    C: SymbolicMatrix
    g: SymbolicMatrix
    f: SymbolicMatrix

    def torque(self, phi_ddot: Any) -> SymbolicMatrix:
        """tau for accelerations, (2.15)."""
        rates = sp.Matrix(self.phi_dot)
        return self.D * sp.Matrix(phi_ddot) + self.C * rates + self.g + self.f


def symbolic_dynamics(model: InertialModel) -> SymbolicDynamics:
    """All terms of (2.15) as expressions of phi1.., phid1.. and the model's own symbols.

    Raises ValueError: a symbol of the model is that of a motor angle or of its rate.
    """
    phi, phi_dot = motor_symbols(model.robot), motor_symbols(model.robot, "phi_dot")
    if taken := model.free_symbols.intersection(phi + phi_dot):
        names = ", ".join(sorted(map(str, taken)))
        raise ValueError(f"{names} of {model.robot.name}: phi1.. and phid1.. are motor variables")
    D, potential = _energies(model, phi)
    for i, motor in enumerate(model.motors):
        D[i, i] += exact(motor.inertia)
    pairs = zip(model.motors, phi_dot, strict=True)
    f = [exact(m.viscous) * rate + exact(m.coulomb) * sp.sign(rate) for m, rate in pairs]
    g = sp.Matrix([potential.diff(angle) for angle in phi])
    n, d = len(phi), [D.diff(angle) for angle in phi]

    def element(k: int, j: int) -> Expression:  # Christoffel symbols times rates
        terms = ((d[i][k, j] + d[j][k, i] - d[k][i, j]) * phi_dot[i] / 2 for i in range(n))
        return sp.Add(*terms)

    C = sp.Matrix(n, n, element)
    return SymbolicDynamics(phi, phi_dot, D, C, g, sp.Matrix(f))


def _collected(expression: Expression) -> Expression:
    """Constant sines and cosines as numbers, and like terms together."""
    numbers = (f for f in expression.atoms(sp.cos, sp.sin) if f.is_number and f not in (0, 1))
    return sp.expand(expression.xreplace({f: simplified_constant(f) for f in numbers}))


def _energies(model: InertialModel, phi: Any) -> tuple[SymbolicMatrix, Expression]:
    """D of all bodies, and the potential energy."""
    robot, coupling = at(model.robot, phi), exact_coupling(model.robot)
    T = [frame.applyfunc(_collected) for frame in matrix_t(robot)]
    D, potential = sp.zeros(len(phi)), sp.S.Zero
    gravity = sp.Matrix([exact(value) for value in model.gravity])
    for number, body in enumerate(model.bodies):
        if body.mass == 0 and not any(body.inertia):
            continue
        frame = T[number + 1]
        c = frame[:3, 3] + frame[:3, :3] * sp.Matrix([exact(v) for v in body.com])
        J_c = c.jacobian(phi)
        J_omega = (angular_jacobian(robot, number + 1) * coupling).applyfunc(_collected)
        xx, yy, zz, xy, xz, yz = map(exact, body.inertia)
        tensor = symmetric((xx, xy, xz, yy, yz, zz))
        local = (frame[:3, :3].T * J_omega).applyfunc(sp.expand)
        D += exact(body.mass) * J_c.T * J_c + local.T * tensor * local
        potential -= exact(body.mass) * gravity.dot(c)
    return D.applyfunc(sp.expand), sp.expand(potential)
