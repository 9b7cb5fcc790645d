"""State equations of rigid and flexible joints, with derived Jacobians."""

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import (
    IRB1400,
    Body,
    Convention,
    InertialModel,
    Link,
    Motor,
    Robot,
    compile_dynamics,
)
from armside.kinematics.equations import forward_kinematics, state_equations
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


RNG = np.random.default_rng(0)


@pytest.fixture(scope="module")
def model(random_model, random_robot):
    rng = np.random.default_rng(7)
    return random_model(rng, random_robot(rng, 2, Convention.STANDARD))


def test_rigid_process_jacobian_is_the_finite_difference(model, tmp_path, central):
    functions = compile_dynamics(model, cache=tmp_path)
    x, tau = RNG.uniform(-1, 1, 4), RNG.uniform(-1, 1, 2)
    F = functions.rigid_rate_jacobian(x, tau)
    expected = central(lambda x: functions.rigid_rate(x, tau), x)
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    assert np.array_equal(functions.rigid_rate_jacobian(x, tau, out=np.empty((4, 4))), F)
    with pytest.raises(ValueError, match=r"x must be \(4,\) and tau \(2,\)"):
        functions.rigid_rate_jacobian(x[:3], tau)


def test_flexible_process_jacobian_is_the_finite_difference(model, interpreted, central):
    rate = interpreted(state_equations.flexible_rate(model))
    along = interpreted(state_equations.rate_tangent(state_equations.flexible_rate(model)))
    x, tau = RNG.uniform(-1, 1, 8), RNG.uniform(-1, 1, 2)
    F = np.stack([along(x, tau, e) for e in np.eye(8)], axis=-1)
    expected = central(lambda x: rate(x, tau), x)
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_flexible_joint_of_one_link_is_the_two_mass_model():
    """(8.1), (8.2) on the arm side: motor inertia rg^2 J_m, ... with the signs of the errata."""
    J, Ja, k, d, fm = sp.symbols("J J_a k d f_m", positive=True)
    motor = Motor(inertia=J, viscous=fm, stiffness=k, damping=d)
    body = Body(mass=0, inertia=(0, 0, Ja, 0, 0, 0))
    one = InertialModel(Robot([Link()]), [body], [motor], gravity=(0, 0, 0))
    program = state_equations.flexible_rate(one)
    qa, qm, qad, qmd = program.inputs[0].elements
    (tau,) = program.inputs[1].elements
    spring = k * (qm - qa) + d * (qmd - qad)
    expected = [qad, qmd, spring / Ja, (tau - fm * qmd - spring) / J]
    difference = sp.Matrix(program.expressions()) - sp.Matrix(expected)
    assert sp.simplify(difference) == sp.zeros(4, 1)
    A = sp.Matrix(program.expressions()).jacobian([qa, qm, qad, qmd])
    assert sp.simplify(A.det()) == 0  # the rigid-body pole at zero, lost with (2.18) as printed


def test_flexible_joints_need_springs(random_robot):
    robot = random_robot(np.random.default_rng(0), 1, Convention.STANDARD)
    model = InertialModel(robot, [Body(mass=1)] * len(robot.links), [Motor(inertia=1)])
    with pytest.raises(ValueError, match="motor 1 needs a stiffness and an inertia"):
        state_equations.flexible_rate(model)
