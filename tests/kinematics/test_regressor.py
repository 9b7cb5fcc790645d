"""Dynamics linear in the inertial parameters. Thesis (2.17)."""

import numpy as np

from armside.kinematics import Body, Convention, InertialModel, Link, Robot, compile_dynamics
from armside.kinematics.regressor import base_parameters, inertial_parameters, regressor

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
