"""Laws of rotation representations, checked for all of them, and what singularities return."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from armside.kinematics import rigid, rotation
from armside.kinematics.expressions import rotation_symbolic as by_symbols

quaternion = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)
TO_AND_FROM = {
    "axis/angle": (rotation.to_axis_angle, lambda pair: rotation.from_axis_angle(*pair)),
    "Euler ZYZ": (rotation.to_euler_zyz, rotation.from_euler_zyz),
    "roll-pitch-yaw": (rotation.to_roll_pitch_yaw, rotation.from_roll_pitch_yaw),
    "quaternion": (rotation.to_quaternion, rotation.from_quaternion),
}
SYMBOLIC = {
    "axis/angle": (by_symbols.to_axis_angle, lambda pair: by_symbols.from_axis_angle(*pair)),
    "Euler ZYZ": (by_symbols.to_euler_zyz, lambda a: by_symbols.from_euler_zyz(*a)),
    "roll-pitch-yaw": (by_symbols.to_roll_pitch_yaw, lambda a: by_symbols.from_roll_pitch_yaw(*a)),
    "quaternion": (by_symbols.to_quaternion, by_symbols.from_quaternion),
}


@pytest.mark.parametrize("name", TO_AND_FROM)
@settings(deadline=None)
@given(q=quaternion)
@example(q=np.array([0.0, 0.5**0.5, 0.5**0.5, 4.21468485e-08]))
def test_to_and_from_are_inverse_anywhere(name, q):
    to, back = TO_AND_FROM[name]
    R = rotation.from_quaternion(q)
    np.testing.assert_allclose(back(to(R)), R, rtol=0, atol=1e-12)


@pytest.mark.parametrize("small", [0.0, 1e-17, 1e-15, 1e-12, 1e-9, 1e-8, 9e-8, 1.1e-7, 1e-5])
@pytest.mark.parametrize("name", ["Euler ZYZ", "roll-pitch-yaw"])
def test_rotations_near_a_singularity_are_kept_to_rounding(name, small):
    to, back = TO_AND_FROM[name]
    ends = (0.0, np.pi) if name == "Euler ZYZ" else (np.pi / 2, -np.pi / 2)
    for middle in ends:
        R = back([0.4, middle + small, -1.3])
        np.testing.assert_allclose(back(to(R)), R, rtol=0, atol=1e-14)


@pytest.mark.parametrize("short", [0.0, 1e-16, 2e-13, 9e-13, 1e-11, 1e-8])
def test_turns_a_little_short_of_half_are_kept_to_rounding(short):
    R = rotation.from_axis_angle([-0.6, 0.48, 0.64], np.pi - short)
    axis, angle = rotation.to_axis_angle(R)
    np.testing.assert_allclose(rotation.from_axis_angle(axis, angle), R, rtol=0, atol=1e-14)


@pytest.mark.parametrize("length", [1e200, 1e-200, 5e-324, 1.7e308])
def test_quaternions_and_axes_of_any_length_are_directions(length):
    half = np.array([1.0, 1.0, 0.0, 0.0])
    R = rotation.from_quaternion(length * half)
    np.testing.assert_allclose(R, rotation.from_quaternion(half), rtol=0, atol=1e-15)
    R = rotation.from_axis_angle(length * half[:3], 0.7)
    np.testing.assert_allclose(R, rotation.from_axis_angle(half[:3], 0.7), rtol=0, atol=1e-15)


def test_huge_angles_are_angles():
    R = rotation.from_axis_angle([0, 0, 1], 1e300)
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "call",
    [
        lambda: rotation.from_quaternion([np.nan, 0, 0, 1]),
        lambda: rotation.from_quaternion([np.inf, 0, 0, 1]),
        lambda: rotation.from_quaternion([1, 0, 0]),
        lambda: rotation.from_axis_angle([1, 0, 0], np.inf),
        lambda: rotation.from_axis_angle([1, 0], 1.0),
        lambda: rotation.from_euler_zyz([np.nan, 0, 0]),
        lambda: rotation.from_roll_pitch_yaw([0, 0]),
        lambda: rotation.quaternion_product([1, 0, 0], [1, 0, 0, 0]),
        lambda: rotation.slerp([0, 0, 0, 0], [1, 0, 0, 0], 0.5),
        lambda: rigid.inverse(np.diag([2.0, 1, 1, 1])),
        lambda: rigid.transform_points(np.eye(4), [1.0, 2.0]),
    ],
)
def test_what_is_no_rotation_or_motion_is_refused(call):
    with pytest.raises(ValueError, match=r"must (be|have|not be)"):
        call()


@pytest.mark.parametrize("name", TO_AND_FROM)
def test_batches_are_their_rows(name):
    to, back = TO_AND_FROM[name]
    R = Rotation.random(5, rng=np.random.default_rng(0)).as_matrix()
    np.testing.assert_allclose(back(to(R)), R, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", TO_AND_FROM)
def test_symbolic_formulas_agree_with_numbers(name):
    to, back = SYMBOLIC[name]
    R = Rotation.random(rng=np.random.default_rng(1)).as_matrix()
    symbolic = to(sp.Matrix(R))
    rebuilt = np.array(sp.Matrix(back(symbolic)).evalf(), dtype=float)
    np.testing.assert_allclose(rebuilt, R, rtol=0, atol=1e-12)
    numeric = TO_AND_FROM[name][0](R)
    flat = np.concatenate([np.ravel(part) for part in numeric]) if name == "axis/angle" else numeric
    parts = [*symbolic[0], symbolic[1]] if name == "axis/angle" else list(symbolic)
    np.testing.assert_allclose([float(p) for p in parts], flat, rtol=0, atol=1e-12)


def test_matrices_are_products_of_elementary_rotations():
    """(3.10) and (3.11), written out."""

    def R(axis, angle):
        return Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()

    a, b, c = 0.3, -0.5, 1.1
    zyz = R(2, a) @ R(1, b) @ R(2, c)
    np.testing.assert_allclose(rotation.from_euler_zyz([a, b, c]), zyz, rtol=0, atol=1e-15)
    rpy = R(2, a) @ R(1, b) @ R(0, c)
    np.testing.assert_allclose(rotation.from_roll_pitch_yaw([a, b, c]), rpy, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "singular", "middles"),
    [
        ("Euler ZYZ", rotation.euler_zyz_singular, (0.0, np.pi)),
        ("roll-pitch-yaw", rotation.roll_pitch_yaw_singular, (np.pi / 2, -np.pi / 2)),
    ],
)
def test_singular_angles_return_a_last_angle_of_zero_and_say_so(name, singular, middles):
    to, back = TO_AND_FROM[name]
    for middle in middles:
        R = back([0.4, middle, 0.3])
        angles = to(R)
        assert singular(R)
        assert angles[2] == 0.0
        np.testing.assert_allclose(back(angles), R, rtol=0, atol=1e-12)
    assert not singular(back([0.4, 0.5, 0.3]))
    assert not rotation.roll_pitch_yaw_singular(np.eye(3))


def test_no_rotation_has_axis_z_and_half_turns_a_positive_axis():
    axis, angle = rotation.to_axis_angle(np.eye(3))
    assert axis.tolist() == [0, 0, 1]
    assert angle == 0
    assert rotation.axis_angle_singular(np.eye(3))
    for k in ([-1, 0, 0], [0, -0.6, 0.8], [-0.6, 0.8, 0]):
        R = rotation.from_axis_angle(k, np.pi)
        axis, angle = rotation.to_axis_angle(R)
        assert rotation.axis_angle_singular(R)
        np.testing.assert_allclose(axis, -np.array(k), rtol=0, atol=1e-9)
        assert angle == pytest.approx(np.pi)


@given(p=quaternion, q=quaternion)
def test_quaternion_product_is_matrix_product(p, q):
    R = rotation.from_quaternion(rotation.quaternion_product(p, q))
    expected = rotation.from_quaternion(p) @ rotation.from_quaternion(q)
    np.testing.assert_allclose(R, expected, rtol=0, atol=1e-12)


def test_slerp_turns_about_one_axis_at_constant_speed_the_shorter_way():
    start = rotation.to_quaternion(rotation.from_axis_angle([1, 2, 3], 0.2))
    end = rotation.to_quaternion(rotation.from_axis_angle([1, 2, 3], 1.4))
    path = rotation.slerp(start, -end, np.linspace(0, 1, 7))  # -end is the same rotation
    expected = rotation.from_axis_angle([[1, 2, 3]] * 7, np.linspace(0.2, 1.4, 7))
    np.testing.assert_allclose(rotation.from_quaternion(path), expected, rtol=0, atol=1e-12)


def test_what_is_no_rotation_is_refused():
    for R in (2 * np.eye(3), np.diag([1, 1, -1]), np.full((3, 3), np.nan), np.eye(4)):
        with pytest.raises(ValueError, match="R must"):
            rotation.to_quaternion(R)
    with pytest.raises(ValueError, match="quaternion"):
        rotation.from_quaternion([0, 0, 0, 0])
    with pytest.raises(ValueError, match="axis"):
        rotation.from_axis_angle([0, 0, 0], 1.0)


@settings(deadline=None)
@given(q=quaternion)
def test_rigid_motions_invert_and_move_points(q):
    T = rigid.transform(rotation.from_quaternion(q), [1.0, -2.0, 3.0])
    p = np.array([0.3, 0.2, 0.1])
    np.testing.assert_allclose(rigid.inverse(T) @ T, np.eye(4), rtol=0, atol=1e-14)
    moved = rigid.transform_points(T, p)
    np.testing.assert_allclose(moved, (T @ [*p, 1])[:3], rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        rigid.transform_points(rigid.inverse(T), moved), p, rtol=0, atol=1e-14
    )


def test_rigid_motion_of_wrong_shape_is_refused():
    with pytest.raises(ValueError, match=r"R must be \(\.\.\., 3, 3\)"):
        rigid.transform(np.eye(4), np.zeros(3))
