"""Robots as data: what is accepted, what is refused, and in which words."""

import math

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import IRB1400, LARGE_ROBOT, Convention, Joint, Link, Robot


def test_a_joint_type_that_is_none_is_refused_by_name():
    with pytest.raises(TypeError, match=r"joint must be one of Joint\.REVOLUTE.*got 'r'"):
        Link(joint="r")  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_link_parameters_must_be_finite(value):
    with pytest.raises(ValueError, match="alpha must be finite"):
        Link(alpha=value)


@pytest.mark.parametrize("value", [None, True, 1j, [1.0]])
def test_link_parameters_must_be_numbers_or_expressions(value):
    with pytest.raises(TypeError, match="theta must be a number"):
        Link(theta=value)


def test_coupling_of_the_wrong_shape_says_what_is_expected():
    with pytest.raises(ValueError, match=r"coupling must have shape \(2, 2\).*got \(3, 3\)"):
        Robot([Link(), Link()], coupling=np.eye(3))


def test_singular_coupling_is_refused():
    with pytest.raises(ValueError, match="coupling must be invertible"):
        Robot([Link(), Link()], coupling=[[1, 1], [1, 1]])


def test_nan_in_the_offset_is_refused():
    with pytest.raises(ValueError, match="offset must be finite"):
        Robot([Link()], offset=[math.nan])


def test_a_robot_has_links_and_a_convention():
    with pytest.raises(TypeError, match="links must be one or more"):
        Robot([])
    with pytest.raises(TypeError, match="convention must be"):
        Robot([Link()], convention="modified")  # type: ignore[arg-type]


def test_fixed_links_have_no_joint_variable():
    robot = Robot([Link(joint=Joint.FIXED), Link(), Link(joint=Joint.PRISMATIC)])
    assert robot.n_joints == 2
    assert robot.moving == (1, 2)


def test_joint_variables_of_the_irb1400_are_those_of_table_4_2():
    phi = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    theta = [0.1, 0.2 - math.pi / 2, -0.2 + 0.3, 0.4, 0.5, 0.6 + math.pi]
    np.testing.assert_allclose(IRB1400.joint_variables(phi), theta, rtol=0, atol=1e-15)


def test_motor_angles_invert_joint_variables():
    phi = np.random.default_rng(0).normal(size=(5, 6))
    back = IRB1400.motor_angles(IRB1400.joint_variables(phi))
    np.testing.assert_allclose(back, phi, rtol=0, atol=1e-14)


def test_robots_are_equal_when_their_data_are():
    links = [Link(theta=1, a=0.5)]
    assert Robot(links) == Robot(links, name="another name")
    assert Robot(links) != Robot(links, convention=Convention.MODIFIED)
    assert hash(Robot(links)) == hash(Robot(links))
    assert IRB1400 != LARGE_ROBOT


def test_the_coupling_of_a_robot_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        IRB1400.coupling[0, 0] = 2.0


@pytest.mark.parametrize("function", [IRB1400.joint_variables, IRB1400.motor_angles])
@pytest.mark.parametrize("given", [[1.0], 1.0, np.zeros((6, 1)), np.zeros(7)])
def test_joint_variables_and_motor_angles_have_one_entry_for_each_joint(function, given):
    with pytest.raises(ValueError, match=r"must have shape \(\.\.\., 6\)"):
        function(given)


@pytest.mark.parametrize("value", [10**400, -(10**400), sp.oo, sp.nan, sp.I, sp.Integer(10) ** 400])
def test_numbers_that_no_float_holds_are_refused(value):
    with pytest.raises(ValueError, match="d must be"):
        Link(d=value)
