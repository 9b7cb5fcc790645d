"""Derivatives of straight-line programs."""

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import IRB1400
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.equations.derivative import jacobian_of
from armside.kinematics.equations.program import Argument, StraightLineProgram

PHI, PHI_DOT = np.random.default_rng(0).uniform(-1, 1, (2, 6))


def test_tangent_of_the_jacobian_is_its_time_derivative(interpreted):
    J = interpreted(forward_kinematics.jacobian(IRB1400))
    J_dot = interpreted(forward_kinematics.jacobian_rate(IRB1400))(PHI, PHI_DOT)
    h = 1e-6
    expected = (J(PHI + h * PHI_DOT) - J(PHI - h * PHI_DOT)) / (2 * h)
    np.testing.assert_allclose(J_dot, expected, rtol=0, atol=1e-9)


def test_derivative_of_a_sign_is_zero_and_of_an_unknown_input_an_error():
    x = sp.Symbol("x", real=True)
    block = Argument("x", (1,), (x,))
    program = StraightLineProgram(
        "p", (block,), (), (Argument("y", (1,), (x**2 + 3 * sp.sign(x),)),)
    )
    H = jacobian_of(program, ("x",))
    assert H.expressions() == (2 * x,)
    with pytest.raises(ValueError, match=r"unknown inputs \['z'\]; inputs: x"):
        jacobian_of(program, ("z",))
