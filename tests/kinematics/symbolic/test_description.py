"""Singular configurations of an elbow arm: symbolic conditions and numeric measures."""

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import (
    IRB1400,
    LARGE_ROBOT,
    Body,
    Convention,
    InertialModel,
    Link,
    Motor,
    Robot,
    UnsolvableGeometryError,
    compile,
)
from armside.kinematics.equations import state_equations
from armside.kinematics.equations.dynamics import gravity_torque, mass_matrix
from armside.kinematics.symbolic.description import (
    conditions,
    decoupled_determinant,
    manipulability,
)

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("robot", [IRB1400, LARGE_ROBOT], ids=lambda robot: robot.name)
def test_determinant_is_the_product_of_its_factors(robot):
    arm, wrist = decoupled_determinant(robot)
    at_wrist = Robot([*robot.links[:5], Link()], robot.coupling, robot.offset)
    functions = compile(at_wrist)
    for phi in RNG.uniform(-1, 1, (5, 6)):
        theta = robot.joint_variables(phi)
        values = {sp.Symbol(f"theta_{i}", real=True): theta[i - 1] for i in (2, 3, 5)}
        J_theta = functions.jacobian(phi) @ np.linalg.inv(robot.coupling)
        expected = float((arm * wrist).subs(values))
        assert np.linalg.det(J_theta) == pytest.approx(expected, rel=1e-9)


def test_conditions_vanish_at_the_singularities_and_name_them():
    found = conditions(LARGE_ROBOT)
    theta2, theta3, theta5 = (sp.Symbol(f"theta_{i}", real=True) for i in (2, 3, 5))
    assert found.elbow.free_symbols == {theta3}
    assert found.shoulder.free_symbols == {theta2, theta3}
    assert sp.solve(found.wrist, theta5)[0] == 0
    stretched = sp.atan2(-sp.Rational(571, 100), 1)
    assert abs(float(found.elbow.subs(theta3, stretched))) < 1e-12


def test_conditions_need_a_spherical_wrist():
    with pytest.raises(UnsolvableGeometryError, match="7 joints"):
        conditions(Robot([Link()] * 7))


def test_manipulability_is_the_volume_of_the_velocity_ellipsoid():
    """sqrt(det J J'), the product of the singular values, which is 0 where the wrist aligns."""
    phi = np.random.default_rng(0).uniform(-1, 1, (20, 6))
    J = compile(IRB1400).jacobian(phi)
    volume = np.sqrt(np.linalg.det(J @ np.swapaxes(J, 1, 2)))
    assert manipulability(J) == pytest.approx(volume, rel=1e-9)
    aligned = compile(IRB1400).jacobian([0.1, 0.2, 0.3, 0.4, 0.0, 0.6])
    assert manipulability(aligned) == pytest.approx(0, abs=1e-12)
    assert np.array_equal(manipulability(J[:, :, :3]), np.zeros(20))  # of fewer than six joints
    # twice as long an arm, in metres: three of six dimensions double
    assert manipulability(J * np.array([2, 2, 2, 1, 1, 1])[:, None]) == pytest.approx(8 * volume)


@pytest.fixture(scope="module")
def pendulum():
    """Two links with elastic gears and losses, in a plane with gravity."""
    robot = Robot([Link(a=0.5), Link(a=0.4)], convention=Convention.STANDARD)
    bodies = [
        Body(mass=3.0, com=(-0.25, 0, 0), inertia=(0, 0.06, 0.06, 0, 0, 0)),
        Body(mass=2.0, com=(-0.2, 0, 0), inertia=(0, 0.03, 0.03, 0, 0, 0)),
    ]
    motors = [
        Motor(inertia=0.4, viscous=0.3, coulomb=0.2, stiffness=900.0, damping=1.5),
        Motor(inertia=0.2, viscous=0.1, coulomb=0.1, stiffness=500.0, damping=0.7),
    ]
    return InertialModel(robot, bodies, motors, gravity=(0, -9.82, 0))


def test_energy_of_elastic_gears_falls_by_what_dampers_and_friction_take(pendulum, interpreted):
    """d/dt (kinetic + elastic + potential) = tau' phi_m' - d w'w - f v'v - c |v|, at any state."""
    rate = interpreted(state_equations.flexible_rate(pendulum))
    mass = interpreted(mass_matrix(InertialModel(pendulum.robot, pendulum.bodies,
                                                 gravity=pendulum.gravity)))  # fmt: skip
    gravity = interpreted(gravity_torque(pendulum))
    J, k, d, f, c = (
        np.array([float(getattr(motor, name)) for motor in pendulum.motors])
        for name in ("inertia", "stiffness", "damping", "viscous", "coulomb")
    )
    rng, h = np.random.default_rng(1), 1e-6
    for _ in range(5):
        x, tau = rng.uniform(-1, 1, 8), rng.uniform(-5, 5, 2)
        arm, _, arm_rate, motor_rate = x.reshape(4, 2)
        x_dot = rate(x, tau)

        def kinetic_and_elastic(x):
            a, m, ad, md = x.reshape(4, 2)
            kinetic = 0.5 * ad @ mass(a) @ ad + 0.5 * J @ md**2
            return kinetic + 0.5 * k @ (m - a) ** 2

        ahead, behind = (kinetic_and_elastic(x + sign * h * x_dot) for sign in (1, -1))
        power = (ahead - behind) / (2 * h) + gravity(arm) @ arm_rate
        slip = motor_rate - arm_rate
        losses = d @ slip**2 + f @ motor_rate**2 + c @ np.abs(motor_rate)
        assert power == pytest.approx(tau @ motor_rate - losses, rel=1e-6)
