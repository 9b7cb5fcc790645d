"""Size of programs of pose, Jacobian and its rate, and the full expressions that they share."""

import time

import numpy as np
import sympy as sp

from armside.kinematics import Link, Robot
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.expressions.symbols import moving, symbol, t
from armside.kinematics.symbolic import procedures as symbolic


def parametric(theta) -> Robot:
    """Six revolute links, every parameter a symbol."""
    return Robot(
        [Link(theta(i), symbol("d", i), symbol("a", i), symbol("alpha", i)) for i in range(1, 7)]
    )


def test_full_symbolic_jacobian_and_its_derivative_in_time():
    """1 s and 8 s on an idle core; three times that of processor time here. 50718 operations are
    90 pages of A4.
    """
    start = time.process_time()
    J = symbolic.jacobian(parametric(lambda i: moving("theta", i)))
    built = time.process_time()
    J_dot = J.diff(t)
    done = time.process_time()
    assert built - start < 3 * 1.0
    assert done - built < 3 * 8.0
    constant = symbolic.jacobian(parametric(lambda i: symbol("theta", i)))
    assert sp.count_ops(constant) == 50718
    assert J_dot.has(moving("theta", 6).diff(t))


def test_shared_program_is_the_full_expression(interpreted):
    """At random numbers, since 50718 operations are not to be simplified."""
    rng = np.random.default_rng(0)
    robot = parametric(lambda i: 0)
    program = forward_kinematics.jacobian(robot)
    phi, parameters = program.inputs
    full = symbolic.jacobian(parametric(lambda i: phi.elements[i - 1]))
    evaluate = sp.lambdify([phi.elements, parameters.elements], full, cse=True)
    values = rng.uniform(-1, 1, 6), rng.uniform(-1, 1, 18)
    np.testing.assert_allclose(interpreted(program)(*values), evaluate(*values), rtol=0, atol=1e-13)
