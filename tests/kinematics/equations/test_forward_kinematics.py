"""Programs of pose, Jacobian, its rate and acceleration against the product of link transforms.

Velocities and accelerations are differences of positions: no equation of motion is used twice.
"""

import time

import numpy as np
import pytest
import sympy as sp

from armside.kinematics import IRB1400, Convention, Joint, Link, Robot
from armside.kinematics.equations import forward_kinematics
from armside.kinematics.equations import forward_kinematics as programs
from armside.kinematics.expressions.symbols import moving, symbol, t
from armside.kinematics.rigid import link_transform, standard_links
from armside.kinematics.symbolic import procedures as symbolic

H = 1e-4  # step of central differences; they err by h^2 times third derivatives
COUPLING = np.array([[1.0, 0.0, 0.0], [0.4, 1.0, 0.0], [-0.7, 0.3, 1.0]])
ROBOTS = {
    "revolute": (
        Link(d=0.3, a=0.2, alpha=-0.7),
        Link(theta=0.1, a=0.5, alpha=0.4),
        Link(d=0.2, a=0.3, alpha=1.1),
    ),
    "sliding": (
        Link(a=0.2, alpha=0.9),
        Link(theta=0.6, a=0.1, alpha=-0.8, joint=Joint.PRISMATIC),
        Link(d=0.4, a=0.25, alpha=0.3),
    ),
    "with a constant link": (
        Link(a=0.2, alpha=-0.5),
        Link(theta=0.5, d=0.1, a=0.3, alpha=0.2, joint=Joint.FIXED),
        Link(d=0.1, a=0.4, alpha=0.7),
        Link(a=0.15, alpha=-0.4, joint=Joint.PRISMATIC),
        Link(theta=-0.3, a=0.2, joint=Joint.FIXED),
    ),
}


@pytest.fixture(scope="module", params=ROBOTS)
def robot(request):
    return Robot(ROBOTS[request.param], coupling=COUPLING, offset=[0.2, -0.1, 0.3])


@pytest.fixture(scope="module")
def functions(robot, interpreted):
    names = ("pose", "jacobian", "jacobian_rate", "acceleration")
    return {name: interpreted(getattr(programs, name)(robot)) for name in names}


@pytest.fixture(params=range(3))
def motion(request):
    """phi(t), and its value, rate and acceleration at t = 0."""
    phi, rate, acceleration = np.random.default_rng(request.param).uniform(-1, 1, (3, 3))
    return lambda t: phi + t * rate + 0.5 * t**2 * acceleration, phi, rate, acceleration


def by_links(robot, phi):
    """T_base_tool as the product of link transforms, standard or modified alike. Thesis (3.26)."""
    q, T = iter(COUPLING @ phi + robot.offset), np.eye(4)
    for link in standard_links(robot):
        T = T @ link_transform(link, next(q) if link.moves else 0.0)
    return T


def rate_of_rotation(at, t):
    """(3,) [rad/s], angular velocity in base axes from the orientation at nearby instants."""
    R_dot = (at(t + H)[:3, :3] - at(t - H)[:3, :3]) / (2 * H)
    omega = R_dot @ at(t)[:3, :3].T
    return 0.5 * np.array([omega[2, 1] - omega[1, 2], omega[0, 2] - omega[2, 0],
                           omega[1, 0] - omega[0, 1]])  # fmt: skip


def test_the_pose_is_the_product_of_the_links(robot, functions, motion):
    _, phi, *_ = motion
    assert functions["pose"](phi) == pytest.approx(by_links(robot, phi), abs=1e-14)


def test_a_modified_table_is_rot_x_trans_x_rot_z_trans_z(interpreted):
    """Craig's order of the elementary motions, written out."""
    links = (Link(d=0.3, a=0.2, alpha=-0.7), Link(d=0.1, a=0.5, alpha=0.4))
    robot = Robot(links, convention=Convention.MODIFIED)
    pose, T = interpreted(programs.pose(robot)), np.eye(4)
    phi = np.array([0.3, -0.8])
    for link, theta in zip(links, phi, strict=True):
        c, s = np.cos(link.alpha), np.sin(link.alpha)
        about_x = np.array([[1, 0, 0, link.a], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])
        c, s = np.cos(theta), np.sin(theta)
        about_z = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, link.d], [0, 0, 0, 1]])
        T = T @ about_x @ about_z
    assert pose(phi) == pytest.approx(T, abs=1e-14)


def test_the_jacobian_takes_motor_rates_to_velocity_and_rotation(robot, functions, motion):
    at, phi, rate, _ = motion

    def T(t):
        return by_links(robot, at(t))

    v = (T(H)[:3, 3] - T(-H)[:3, 3]) / (2 * H)
    expected = np.concatenate([v, rate_of_rotation(T, 0.0)])
    assert functions["jacobian"](phi) @ rate == pytest.approx(expected, abs=1e-6)


def test_the_acceleration_is_the_second_difference_of_the_motion(robot, functions, motion):
    at, phi, rate, acceleration = motion

    def T(t):
        return by_links(robot, at(t))

    a = (T(H)[:3, 3] - 2 * T(0.0)[:3, 3] + T(-H)[:3, 3]) / H**2
    alpha = (rate_of_rotation(T, H) - rate_of_rotation(T, -H)) / (2 * H)
    found = functions["acceleration"](phi, rate, acceleration)
    assert found == pytest.approx(np.concatenate([a, alpha]), abs=2e-6)
    # (2.14): the same by the Jacobian and its rate
    J, J_dot = functions["jacobian"](phi), functions["jacobian_rate"](phi, rate)
    assert found == pytest.approx(J @ acceleration + J_dot @ rate, abs=1e-12)


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


def test_operations_after_sharing_are_within_the_limits():
    robot = parametric(lambda i: 0)
    assert forward_kinematics.jacobian(robot).operations <= 340
    assert forward_kinematics.jacobian_rate(robot).operations <= 1619
    assert forward_kinematics.jacobian(IRB1400).operations <= 178
    assert forward_kinematics.jacobian_rate(IRB1400).operations <= 670


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
