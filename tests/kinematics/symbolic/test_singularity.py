"""Singular configurations of an elbow arm: symbolic conditions and numeric measures."""

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import (
    IRB1400,
    LARGE_ROBOT,
    Link,
    Robot,
    UnsolvableGeometryError,
    compile,
)
from armside.kinematics.symbolic.description import (
    conditions,
    decoupled_determinant,
    distance_to_singularity,
    lost_directions,
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


def test_measures_fall_to_zero_at_a_singularity():
    functions = compile(IRB1400)
    near = [functions.jacobian([0.1, 0.2, 0.3, 0.4, q5, 0.6]) for q5 in (1e-1, 1e-3, 1e-5, 0)]
    for measure in (manipulability(near), distance_to_singularity(near)):
        assert (np.diff(measure) < 0).all()
        assert measure[-1] == pytest.approx(0, abs=1e-12)
    assert lost_directions(near[-1]).shape == (6, 1)
    assert lost_directions(near[0]).shape == (6, 0)
