"""The worked examples of thesis chapter 4, as symbolic equalities."""

import pytest
import sympy as sp

from armside.kinematics import IRB1400, IRB1400_IMU, Convention, Joint, Link, Robot
from armside.kinematics.expressions.symbols import moving, symbol, t
from armside.kinematics.symbolic import procedures as dh

f1, f2, f3, f4 = (moving("phi", i) for i in range(1, 5))
c1, s1, c2, s2 = sp.cos(f1), sp.sin(f1), sp.cos(f2), sp.sin(f2)
half, point6, point15 = sp.pi / 2, sp.Rational(3, 5), sp.Rational(3, 20)
d1 = sp.Rational(19, 40)

LINK1 = Link("phi[1](t)", 0.475, 0.15, "-Pi/2")
LINK2 = Link("phi[2](t) - Pi/2", 0, 0.6, 0)
LINK3 = Link("-phi[2](t) + phi[3](t)", 0, 0.12, "-Pi/2")
LINK4 = Link("phi[4](t)", 0.72, 0, "Pi/2")
TWO = Robot([LINK1, LINK2])
ZERO_POSE = [
    Link(0, 0.475, 0.15, "-Pi/2"),
    Link("-Pi/2", 0, 0.6, 0),
    Link(0, 0, 0.12, "-Pi/2"),
    Link(0, 0.72, 0, "Pi/2"),
    Link(0, 0, 0, "-Pi/2"),
    Link("Pi", 0.085, 0, 0),
]


def same(actual, expected) -> bool:
    """Equal as expressions: the difference simplifies to zero, entry by entry."""
    difference = sp.Matrix(actual) - sp.Matrix(expected)
    return all(sp.simplify(entry) == 0 for entry in difference)


def test_table_4_2_from_motor_angles():
    phi = [symbol("phi", i) for i in range(1, 7)]
    theta = dh.dh_parameter(phi, [0, -half, 0, 0, 0, sp.pi], IRB1400.coupling.astype(int))
    p1, p2, p3, p4, p5, p6 = phi
    assert same(theta, [p1, p2 - half, -p2 + p3, p4, p5, p6 + sp.pi])
    assert [link.theta for link in dh.at(IRB1400, phi).links] == list(theta)


def test_4_11_links_and_4_12_robot():
    link1 = Link("theta[1]", "d[1]", "a[1]", "alpha[1]", Joint.PRISMATIC)
    link2 = Link("theta[2]", "d[2]", "a[2]", "alpha[2]", Joint.REVOLUTE)
    assert Robot([link1, link2]).links == (link1, link2)
    assert dh.variable_link(link1, "q", 1).d == moving("q", 1)
    assert dh.variable_link(link2, "q", 2).theta == moving("q", 2)
    assert dh.variable_link(Link(0, 1, 2, 3)) == Link(0, 1, 2, 3)
    for text, index in (("phi[2](t) - Pi/2", 2), ("phi[3](t) - phi[2](t)", 3), ("theta[4]", 4)):
        assert dh.variable_link(Link(text)).theta == moving("q", index)
    assert dh.variable_link(Link("theta(t)")).theta == moving("q")


def test_4_13_link_transform():
    th, d, a, al = (symbol(name, 1) for name in ("theta", "d", "a", "alpha"))
    c, s, ca, sa = sp.cos(th), sp.sin(th), sp.cos(al), sp.sin(al)
    expected = [
        [c, -s * ca, s * sa, a * c],
        [s, c * ca, -c * sa, a * s],
        [0, sa, ca, d],
        [0, 0, 0, 1],
    ]
    assert dh.matrix_a(Link(th, d, a, al)) == sp.Matrix(expected)


def test_a_modified_link_turns_about_x_before_z():
    """Craig: Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d), each a matrix of its own."""
    th, d, a, al = (symbol(name, 1) for name in ("theta", "d", "a", "alpha"))
    turns = [sp.rot_axis1(-al), sp.eye(3), sp.rot_axis3(-th), sp.eye(3)]
    moves = [[0, 0, 0], [a, 0, 0], [0, 0, 0], [0, 0, d]]
    T = sp.eye(4)
    for R, p in zip(turns, moves, strict=True):
        T *= sp.Matrix(sp.BlockMatrix([[R, sp.Matrix(p)], [sp.zeros(1, 3), sp.eye(1)]]))
    assert same(dh.matrix_a(Link(th, d, a, al), Convention.MODIFIED), T)


def test_4_14_and_4_15_link_transforms_of_the_zero_pose():
    A1 = [[1, 0, 0, point15], [0, 0, 1, 0], [0, -1, 0, d1], [0, 0, 0, 1]]
    A2 = [[0, 1, 0, 0], [-1, 0, 0, -point6], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert dh.matrix_a(ZERO_POSE[0]) == sp.Matrix(A1)
    assert dh.matrix_a(ZERO_POSE[1]) == sp.Matrix(A2)


def test_4_16_to_4_18_transforms_of_the_zero_pose():
    T = dh.matrix_t(ZERO_POSE)
    expected = [[0, 1, 0, point15], [0, 0, 1, 0], [1, 0, 0, d1 + point6], [0, 0, 0, 1]]
    assert T[2] == sp.Matrix(expected)
    assert dh.position_t(T[2]) == sp.Matrix([point15, 0, d1 + point6])
    assert dh.rotation_t(T[2]) == sp.Matrix([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    tool = [[0, 0, 1, "0.955"], [0, 1, 0, 0], [-1, 0, 0, "1.195"], [0, 0, 0, 1]]
    assert T[6] == sp.Matrix(tool).applyfunc(sp.nsimplify)
    assert dh.matrix_t(IRB1400)[6] == T[6]


def test_4_19_and_4_20_general_transforms():
    T = dh.matrix_t(TWO)
    T1 = [[c1, 0, -s1, point15 * c1], [s1, 0, c1, point15 * s1], [0, -1, 0, d1], [0, 0, 0, 1]]
    T2 = [
        [c1 * s2, c1 * c2, -s1, point6 * c1 * s2 + point15 * c1],
        [s1 * s2, s1 * c2, c1, point6 * s1 * s2 + point15 * s1],
        [c2, -s2, 0, d1 + point6 * c2],
        [0, 0, 0, 1],
    ]
    assert same(T[1], T1)
    assert same(T[2], T2)


def test_4_25_point_of_frame_2_in_the_base():
    p = dh.transformation_t([1, 1, 1], dh.matrix_t(TWO)[2])
    q = sp.Rational(8, 5)
    expected = [
        q * c1 * s2 + c1 * c2 - s1 + point15 * c1,
        q * s1 * s2 + s1 * c2 + c1 + point15 * s1,
        q * c2 - s2 + d1,
    ]
    assert same(p, expected)


def test_4_26_and_4_27_angular_jacobian_of_four_links():
    J = dh.angular_jacobian([LINK1, LINK2, LINK3, LINK4])
    c23, s23 = sp.cos(f2 - f3), sp.sin(f2 - f3)
    expected = [
        [0, -s1, -s1, c1 * s2 * s23 + c1 * c2 * c23],
        [0, c1, c1, s1 * s2 * s23 + s1 * c2 * c23],
        [1, 0, 0, c2 * s23 - s2 * c23],
    ]
    assert same(J, expected)
    assert same(J[:, 3], [c1 * sp.cos(f3), s1 * sp.cos(f3), -sp.sin(f3)])


def test_4_28_and_4_29_jacobian_of_the_zero_pose():
    J_v = [
        ["0", "0.72", "0.12", "0", "0", "0"],
        ["0.955", "0", "0", "0", "0", "0"],
        ["0", "-0.805", "-0.805", "0", "-0.085", "0"],
    ]
    J_w = [[0, 0, 0, 1, 0, 1], [0, 1, 1, 0, 1, 0], [1, 0, 0, 0, 0, 0]]
    assert dh.linear_jacobian(ZERO_POSE) == sp.Matrix(J_v).applyfunc(sp.nsimplify)
    assert dh.angular_jacobian(ZERO_POSE) == sp.Matrix(J_w)


def test_4_30_jacobian_of_prismatic_joints():
    links = [Link(k.theta, k.d, k.a, k.alpha, Joint.PRISMATIC) for k in ZERO_POSE]
    z = [[0, 0, 0, 1, 0, 1], [0, 1, 1, 0, 1, 0], [1, 0, 0, 0, 0, 0]]
    assert dh.jacobian(links) == sp.Matrix([*z, *sp.zeros(3, 6).tolist()])


def test_4_31_corrected_linear_velocity_of_two_links():
    """As printed it is the velocity of frame 1; the errata has the two links."""
    arm = point15 + point6 * s2
    expected = [
        -arm * s1 * f1.diff(t) + point6 * c1 * c2 * f2.diff(t),
        arm * c1 * f1.diff(t) + point6 * s1 * c2 * f2.diff(t),
        -point6 * s2 * f2.diff(t),
    ]
    variables = [symbol("phi", 1), symbol("phi", 2)]
    assert same(dh.linear_velocity(TWO, variables), expected)
    assert same(dh.linear_velocity(TWO), expected)
    printed = [-point15 * s1 * f1.diff(t), point15 * c1 * f1.diff(t), 0]
    assert same(dh.linear_velocity([LINK1]), printed)


def test_4_32_angular_velocity_of_two_links():
    expected = [-s1 * f2.diff(t), c1 * f2.diff(t), f1.diff(t)]
    assert same(dh.angular_velocity(TWO), expected)
    assert same(dh.velocity(TWO)[3:, 0], expected)


def test_linear_velocity_is_the_derivative_of_the_position():
    for links in ([LINK1, LINK2], [LINK1, LINK2, LINK3, LINK4]):
        position = dh.position_t(dh.matrix_t(links)[-1])
        assert same(dh.linear_velocity(links), position.diff(t))


def test_accelerations_are_derivatives_of_velocities():
    a = dh.acceleration(TWO)
    assert same(a[:3, 0], dh.position_t(dh.matrix_t(TWO)[2]).diff(t, 2))
    assert same(dh.linear_acceleration(TWO), a[:3, 0])
    assert same(dh.angular_acceleration(TWO), dh.angular_velocity(TWO).diff(t))


def test_a_variable_left_out_stands_still():
    w = dh.angular_velocity(TWO, [symbol("phi", 1)])
    assert same(w, [0, 0, f1.diff(t)])


def test_5_12_corrected_rates_of_the_joint_variables():
    """(theta_1', theta_2', theta_3') = (f1', f2', f3' - f2'), and zero for the IMU's links."""
    links = [LINK1, LINK2, LINK3, LINK4]
    rates = dh.joint_rates(Robot(links), None)
    expected = [f1.diff(t), f2.diff(t), f3.diff(t) - f2.diff(t), f4.diff(t)]
    assert same(rates, expected)
    with_imu = [*links, Link("Pi", 0.032, 0.09, "Pi/2"), Link("Pi/2", -0.026, 0, "Pi/2")]
    assert same(dh.joint_rates(Robot(with_imu), None), [*expected, 0, 0])
    assert dh.jacobian(with_imu).shape == (6, 6)


def test_transforms_between_any_two_frames_compose():
    T = dh.matrix_t(TWO)
    from_one = dh.matrix_t(TWO, start=1)
    assert from_one[0] == sp.eye(4)
    assert same(T[1] * from_one[1], T[2])
    with pytest.raises(ValueError, match="start must be a frame from 0 to 2"):
        dh.matrix_t(TWO, start=3)


def test_jacobian_of_an_earlier_frame_has_zero_columns_beyond_it():
    """Thesis 3.4.4: any frame may take the tool's place."""
    J = dh.jacobian(ZERO_POSE, frame=2)
    assert J[:, 2:] == sp.zeros(6, 4)
    assert J[:, :2] == dh.jacobian(ZERO_POSE[:2])


def test_motor_jacobian_carries_the_coupling():
    phi = dh.motor_functions(IRB1400)
    J = dh.motor_jacobian(IRB1400, [0] * 6)
    assert J[:, 1] == sp.Matrix([point6, 0, 0, 0, 0, 0])
    with pytest.raises(ValueError, match="has 6 motors, got 5"):
        dh.at(IRB1400, phi[:5])


def test_statics_is_the_transpose():
    F = sp.Matrix(sp.symbols("f_x f_y f_z m_x m_y m_z"))
    assert dh.joint_torques(ZERO_POSE, F) == dh.jacobian(ZERO_POSE).T * F


def test_imu_links_of_table_5_1_in_the_zero_pose():
    T = dh.matrix_t(IRB1400_IMU)
    assert dh.rotation_t(T[8]) == sp.eye(3)
    offset = dh.position_t(T[8]) - dh.position_t(T[6])
    assert offset == sp.Matrix(["0.032", "-0.026", "0.09"]).applyfunc(sp.nsimplify)


def test_a_point_has_three_coordinates():
    with pytest.raises(ValueError, match="a point has 3 coordinates"):
        dh.transformation_t([1, 2], sp.eye(4))
