"""Dynamics linear in the inertial parameters. Thesis (2.17)."""

from dataclasses import replace

import numpy as np
import pytest

from armside.kinematics import (
    Body,
    Convention,
    InertialModel,
    Link,
    Robot,
    compile_dynamics,
    compile_inverse_dynamics_jacobian,
)
from armside.kinematics.equations import dynamics
from armside.kinematics.regressor import (
    base_parameters,
    inertial_parameters,
    regressor,
    torque_tangent,
)

ROUNDING = 1e-10  # relative


def test_regressor_times_parameters_is_the_torque(random_model, random_robot, tmp_path):
    rng = np.random.default_rng(4)
    model = random_model(rng, random_robot(rng, 3, Convention.STANDARD))
    model = InertialModel(model.robot, model.bodies, gravity=model.gravity)
    motion = rng.uniform(-1, 1, (3, 5, 3))
    Y = regressor(model, *motion, cache=tmp_path)
    tau = compile_dynamics(model, cache=tmp_path).inverse_dynamics(*motion)
    expected = Y @ inertial_parameters(model)
    np.testing.assert_allclose(tau, expected, rtol=0, atol=ROUNDING * np.abs(tau).max())
    single = regressor(model, *motion[:, 0], cache=tmp_path)
    np.testing.assert_allclose(single, Y[0], rtol=0, atol=1e-14 * np.abs(Y).max())


def test_base_parameters_of_a_planar_arm():
    """Gravity along the axes: two moments of inertia and the coupling through two first moments
    remain of twenty parameters.
    """
    robot = Robot([Link(a=0.7), Link(a=0.4)])
    model = InertialModel(robot, [Body(mass=1)] * 2, gravity=(0, 0, -9.82))
    found = base_parameters(model, np.random.default_rng(0))
    assert len(found.independent) == 4
    rng = np.random.default_rng(1)
    motion = rng.uniform(-2, 2, (3, 20, 2))
    Y = regressor(model, *motion)
    theta = rng.normal(size=20)
    reduced = Y[..., list(found.independent)] @ found.values(theta)
    np.testing.assert_allclose(reduced, Y @ theta, rtol=0, atol=1e-10)


DIFFERENCES = 1e-7


@pytest.mark.parametrize("convention", Convention)
def test_derivatives_of_random_models_are_those_of_differences(
    convention, random_robot, random_model, interpreted, central
):
    rng = np.random.default_rng(7)
    model = random_model(rng, random_robot(rng, 3, convention))
    torque, along = (
        interpreted(dynamics.inverse_dynamics(model)),
        interpreted(torque_tangent(model)),
    )
    x = rng.uniform(0.2, 1, 9)
    J = np.stack([along(x, unit) for unit in np.eye(9)], axis=1)
    expected = central(lambda x: torque(*x.reshape(3, 3)), x)
    np.testing.assert_allclose(J, expected, rtol=0, atol=DIFFERENCES * np.abs(expected).max())
    D = interpreted(dynamics.mass_matrix(model))(x[:3])
    np.testing.assert_allclose(J[:, 6:], D, rtol=0, atol=1e-12 * np.abs(D).max())


def test_a_pendulum_has_the_derivatives_of_its_formula(tmp_path):
    """tau = m l^2 phi'' + m g l cos(phi), with g along -y."""
    m, length = 2.0, 0.5
    pendulum = InertialModel(Robot([Link(a=length)]), (Body(mass=m),), gravity=(0, -9.82, 0))
    jacobian = compile_inverse_dynamics_jacobian(pendulum, cache=tmp_path)
    out = np.empty((1, 3))
    found = jacobian([0.3], [0.7], [0.2], out=out)
    assert found is out
    expected = [[-m * 9.82 * length * np.sin(0.3), 0.0, m * length**2]]
    np.testing.assert_allclose(out, expected, rtol=1e-13, atol=1e-13)
    with pytest.raises(ValueError, match=r"shapes \(1,\), \(1,\), \(1,\); got \(2,\)"):
        jacobian([0.3, 0.1], [0.7], [0.2])
    heavier = replace(pendulum, bodies=(Body(mass=2 * m),))
    doubled = compile_inverse_dynamics_jacobian(heavier, cache=tmp_path)([0.3], [0.7], [0.2])
    np.testing.assert_allclose(doubled, 2 * out)
