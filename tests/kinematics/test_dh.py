"""Robots as data: what is accepted, what is refused, and in which words."""

import math
import re

import numpy as np
import pytest
import sympy as sp

from armside import kinematics
from armside.kinematics import (
    IRB1400,
    LARGE_ROBOT,
    Body,
    Convention,
    InertialModel,
    Joint,
    Limits,
    Link,
    Robot,
)
from armside.kinematics.dh import CoupledRange, check_unit
from armside.kinematics.rigid import link_transform
from armside.kinematics.rotation import from_axis_angle

TWO = [Link(), Link()]
REFUSED = [
    (Link, {"joint": "r"}, r"joint must be one of Joint\.REVOLUTE.*got 'r'"),
    *((Link, {"alpha": x}, "alpha must be finite") for x in (math.nan, math.inf, -math.inf)),
    *((Link, {"theta": x}, "theta must be a number") for x in (None, True, 1j, [1.0])),
    *((Link, {"d": x}, "d must be") for x in (10**400, -(10**400), sp.oo, sp.nan, sp.I)),
    (Link, {"d": sp.Integer(10) ** 400}, "d must be"),
    (Robot, {"links": TWO, "coupling": np.eye(3)}, r"shape \(2, 2\).*got \(3, 3\)"),
    (Robot, {"links": TWO, "coupling": [[1, 1], [1, 1]]}, "coupling must be invertible"),
    (Robot, {"links": TWO, "offset": [math.nan, 0]}, "offset must be finite"),
    (Robot, {"links": []}, "links must be one or more"),
    (Robot, {"links": TWO, "convention": "modified"}, "convention must be"),
]

WRONG_KIND = ("joint must be", "theta must be a number", "links must be", "convention must be")


@pytest.mark.parametrize(("make", "given", "said"), REFUSED)
def test_what_is_no_link_or_robot_is_refused_by_name(make, given, said):
    wrong_kind = any(word in said for word in WRONG_KIND)
    with pytest.raises(TypeError if wrong_kind else ValueError, match=said):
        make(**given)


def test_fixed_links_have_no_joint_variable():
    robot = Robot([Link(joint=Joint.FIXED), Link(), Link(joint=Joint.PRISMATIC)])
    assert robot.n_joints == 2
    assert robot.moving == (1, 2)


def test_joint_variables_of_the_irb1400_are_those_of_table_4_2():
    phi = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    theta = [0.1, 0.2 - math.pi / 2, -0.2 + 0.3, 0.4, 0.5, 0.6 + math.pi]
    np.testing.assert_allclose(IRB1400.joint_variables(phi), theta, rtol=0, atol=1e-15)


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


LIMITS = Limits(
    lower=(-1.0, -2.0, -3.0),
    upper=(1.5, 2.5, 3.5),
    speed=(1.0, 2.0, 3.0),
    coupled=(CoupledRange(coefficients=(0.0, -1.0, 1.0), lower=-1.2, upper=0.8),),
)


@pytest.mark.parametrize("axis", range(3))
def test_each_end_of_a_range_belongs_to_it_and_what_is_beyond_does_not(axis):
    free = Limits(lower=LIMITS.lower, upper=LIMITS.upper, speed=LIMITS.speed)
    for end, outwards in ((free.lower[axis], -np.inf), (free.upper[axis], np.inf)):
        phi = np.zeros(3)
        phi[axis] = end
        assert free.contain(phi)
        phi[axis] = np.nextafter(end, outwards)
        assert not free.contain(phi)


@pytest.mark.parametrize(("difference", "inside"), [(-1.2, 1), (-1.21, 0), (0.8, 1), (0.81, 0)])
def test_a_coupled_range_bounds_the_combination_from_both_sides(difference, inside):
    phi = np.array([0.0, 0.5, 0.0])
    phi[2] = phi[1] + difference
    assert bool(LIMITS.contain(phi)) == bool(inside)


def test_a_batch_is_judged_row_by_row():
    phi = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert LIMITS.contain(phi).tolist() == [True, False, False]


def test_ranges_and_speeds_of_both_robots_are_published_ones():
    """ARTE's IRB1410; ros-industrial's irb6600_225_255. 20 deg of transmission angle are kept."""
    small, large = kinematics.IRB1400_LIMITS, kinematics.LARGE_ROBOT_LIMITS
    assert np.rad2deg(small.lower) == pytest.approx([-170, -70, -65, -150, -115, -300])
    assert np.rad2deg(small.upper) == pytest.approx([170, 70, 70, 150, 115, 300])
    assert np.rad2deg(small.speed) == pytest.approx([120, 120, 120, 280, 280, 280])
    (linkage,) = small.coupled
    assert np.rad2deg([linkage.lower, linkage.upper]) == pytest.approx([-70, 70])
    assert np.rad2deg(large.lower) == pytest.approx([-180, -65, -180, -300, -120, -300])
    assert np.rad2deg(large.upper) == pytest.approx([180, 80, 60, 300, 120, 300])
    assert np.rad2deg(large.speed) == pytest.approx([100, 90, 90, 150, 120, 190])
    assert large.coupled == ()


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Limits(lower=(1.0,), upper=(0.0,), speed=(1.0,)), "lower must be below upper"),
        (lambda: Limits(lower=(math.nan,), upper=(1.0,), speed=(1.0,)), "lower must be below"),
        (lambda: Limits(lower=(0, 0), upper=(1,), speed=(1,)), "one entry for each motor"),
        (
            lambda: Limits(lower=(0, 0), upper=(1, 1), speed=(1, 1), coupled=LIMITS.coupled),
            "a coupled range needs 2 coefficients",
        ),
        (
            lambda: CoupledRange(coefficients=(1.0, 1.0), lower=0.0, upper=-1.0),
            "a coupled range needs lower below upper, got 0 and -1",
        ),
    ],
)
def test_ranges_that_hold_nothing_or_do_not_fit_are_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()


def test_gravity_is_that_of_the_thesis_unless_said_otherwise():
    """Thesis (5.2)."""
    model = InertialModel(Robot([Link()]), (Body(mass=1),))
    assert model.gravity == (0, 0, -9.82)


@pytest.mark.parametrize(("moments", "holds"), [((1, 1, 2), True), ((1, 1, 2.001), False)])
def test_a_moment_of_inertia_is_at_most_the_sum_of_the_others(moments, holds):
    """Equality is a flat disc."""
    if holds:
        Body(mass=1, inertia=(*moments, 0, 0, 0))
    else:
        with pytest.raises(ValueError, match="triangle inequality"):
            Body(mass=1, inertia=(*moments, 0, 0, 0))


def at(robot, phi):
    """T_base_tool as the product of link transforms. Thesis (3.26)."""
    q, T = iter(robot.joint_variables(phi)), np.eye(4)
    for link in robot.links:
        T = T @ link_transform(link, next(q) if link.moves else 0.0)
    return T


TOOL_FORWARD = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]


@pytest.mark.parametrize(
    ("robot", "position"),
    [
        (kinematics.IRB1400, [0.15 + 0.72 + 0.085, 0.0, 0.475 + 0.6 + 0.12]),  # thesis 4.3.4
        (kinematics.LARGE_ROBOT, [0.320 + 1.142 + 0.200, 0.0, 0.780 + 1.075 + 0.200]),
    ],
)
def test_the_zero_pose_is_arm_up_and_forearm_forward(robot, position):
    T = at(robot, np.zeros(6))
    assert T[:3, 3] == pytest.approx(position, abs=1e-15)
    assert T[:3, :3] == pytest.approx(np.array(TOOL_FORWARD), abs=1e-15)


def test_motor_3_of_the_irb1400_holds_the_upper_arm_level_whatever_motor_2_does():
    """Thesis (4.10): theta_3 = phi_3 - phi_2; the large robot has no parallelogram."""
    phi = np.array([0.0, 0.4, 0.0, 0.0, 0.0, 0.0])
    leaning = at(kinematics.IRB1400, phi)
    assert leaning[:3, :3] == pytest.approx(np.array(TOOL_FORWARD), abs=1e-15)
    moved = leaning[:3, 3] - at(kinematics.IRB1400, np.zeros(6))[:3, 3]
    assert moved == pytest.approx([0.6 * np.sin(0.4), 0.0, 0.6 * (np.cos(0.4) - 1.0)], abs=1e-15)
    tilted = at(kinematics.LARGE_ROBOT, phi)[:3, :3]
    about_y = from_axis_angle([0.0, 1.0, 0.0], 0.4)
    assert tilted == pytest.approx(about_y @ np.array(TOOL_FORWARD), abs=1e-15)


def test_the_imu_sits_where_the_thesis_measured_it():
    """5.1.1: (32, -26, 90) mm from TCP0 along the base axes of the zero pose, axes aligned."""
    tool, imu = (at(robot, np.zeros(6)) for robot in (kinematics.IRB1400, kinematics.IRB1400_IMU))
    assert imu[:3, 3] - tool[:3, 3] == pytest.approx([0.032, -0.026, 0.090], abs=1e-15)
    assert imu[:3, :3] == pytest.approx(np.eye(3), abs=1e-15)


def test_motor_angles_and_joint_variables_are_each_others_inverse():
    phi = np.random.default_rng(0).uniform(-1, 1, (5, 6))
    for robot in (kinematics.IRB1400, kinematics.LARGE_ROBOT):
        back = robot.motor_angles(robot.joint_variables(phi))
        assert back == pytest.approx(phi, abs=1e-15)
        zero = robot.joint_variables(np.zeros(6))
        assert np.rad2deg(zero) == pytest.approx([0, -90, 0, 0, 0, 180])  # thesis (4.9)


@pytest.mark.parametrize(
    ("quantity", "most", "unit", "like"),
    [
        ("theta", 2 * np.pi, "rad", ("degrees", np.pi / 180)),
        ("alpha", 2 * np.pi, "rad", ("degrees", np.pi / 180)),
        ("range", 6 * np.pi, "rad", ("degrees", np.pi / 180)),
        ("d", 20.0, "m", ("millimetres", 1e-3)),
        ("a", 20.0, "m", ("millimetres", 1e-3)),
        ("slide", 20.0, "m", ("millimetres", 1e-3)),
        ("rotor_inertia", 1.0, "kg m^2", ("kg cm^2", 1e-4)),
    ],
)
def test_a_number_beyond_what_an_arm_can_have_is_refused_with_its_value_in_another_unit(
    quantity, most, unit, like
):
    name, factor = like
    for value in (most, -most):
        check_unit("link 1", quantity, value)
        said = f"at most {most:.4g} {unit}, got {1.5 * value:g}; looks like "
        with pytest.raises(ValueError, match=re.escape(said)) as refused:
            check_unit("link 1", quantity, 1.5 * value)
        assert f"{name}: {1.5 * value * factor:.4g} {unit}" in str(refused.value)
    with pytest.raises(ValueError, match="at most"):
        check_unit("link 1", quantity, most * 1.001)
