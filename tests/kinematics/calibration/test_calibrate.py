"""Splits, regions of use, and data that cannot be right."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armside.kinematics import CATALOGUE
from armside.kinematics.calibration import CalibrationCfg, JointErrors, Measurements, calibrate
from armside.kinematics.calibration.measurements import split_by_pose, unique_poses
from armside.kinematics.calibration.plausibility import _finite, check

from .conftest import R_TRACKER

ARM = CATALOGUE["irb120"]
TRUTH = {"theta_2": 1e-3, "a_2": -4e-4, "alpha_3": 8e-4}
WAVE = np.array([1, 0.6, 0, 0, 0, 0]) * 3e-4


def wavy(phi):
    return WAVE * np.sin(7 * phi + 0.3)


def test_repeats_of_a_pose_are_on_one_side_of_a_split():
    phi = np.repeat(np.random.default_rng(0).normal(size=(50, 6)), 3, axis=0)
    phi = np.random.default_rng(1).permutation(phi + 1e-5)
    for rng in (np.random.default_rng(2), None):
        fitted, held = split_by_pose(phi, 0.5, rng)
        assert sorted([*fitted, *held]) == list(range(150))
        assert not set(unique_poses(phi)[fitted]) & set(unique_poses(phi)[held])
        assert len(fitted) == 75


def test_repeats_that_come_back_with_an_error_are_on_one_side_of_a_split():
    """Within half a milliradian, which is on both sides of any grid."""
    rng = np.random.default_rng(0)
    phi = np.repeat(rng.normal(size=(50, 6)), 4, axis=0)
    of = rng.permutation(200)
    phi = (phi + rng.uniform(-5e-4, 5e-4, phi.shape))[of]
    fitted, held = split_by_pose(phi, 0.5, rng)
    assert not set(of[fitted] // 4) & set(of[held] // 4)
    assert len(fitted) == len(held) == 100


def test_a_slow_motion_is_not_all_one_pose():
    phi = np.linspace(0.0, 0.1, 400)[:, None] * np.ones(6)
    assert 25 <= unique_poses(phi).max() + 1 <= 101


def test_a_split_in_order_fits_the_first_poses():
    phi = np.random.default_rng(0).normal(size=(40, 6))
    fitted, held = split_by_pose(phi, 0.25, None)
    assert list(fitted) == list(range(10))
    assert list(held) == list(range(10, 40))


@pytest.fixture(scope="module")
def wavy_data(measured):
    return measured(
        "irb120", 400, np.random.default_rng(3), errors=TRUTH, noise=2e-5, joint=wavy, targets=1
    )


def test_each_model_is_better_than_the_one_it_contains(wavy_data):
    done = calibrate(ARM, wavy_data, seed=1)
    nominal, geometry, full = (done.errors(name).mean for name in ("nominal", "geometry", "full"))
    assert nominal > 3 * geometry > 3 * full
    assert done.full.problem.choice.joint_errors == JointErrors(40, True)
    assert full < 1e-4


def test_noise_alone_is_left_of_an_arm_whose_errors_are_fitted(measured):
    """Lengths of noise of 20 um an axis: mean 1.596, 95 % below 2.795 (Maxwell's distribution); 200
    held-out poses know the mean to 3 %, and parameters of 200 others leave 4 % more."""
    data = measured("irb120", 400, np.random.default_rng(5), errors=TRUTH, noise=2e-5)
    done = calibrate(ARM, data, CalibrationCfg(joint_errors=JointErrors()))
    assert done.geometry.noise == pytest.approx(2e-5, rel=0.1)
    for name in ("geometry", "full"):
        errors = done.errors(name)
        assert errors.mean == pytest.approx(1.596 * 2e-5, rel=0.15)
        assert errors.p95 == pytest.approx(2.795 * 2e-5, rel=0.2)


def test_where_a_joint_was_not_seen_harmonics_are_refused(wavy_data):
    below = wavy_data.phi[:, 0] < 0.0
    order = np.argsort(~below, kind="stable")
    cfg = CalibrationCfg(in_order=True, fraction=float(below.mean()), joint_errors=JointErrors(40))
    done = calibrate(ARM, wavy_data[order], cfg)
    assert done.inside.mean() < 0.15
    far = done.held_out.phi[:, 0] > 0.5
    assert not done.inside[far].any()
    assert not done.region.contains(done.held_out.phi[far]).any()
    assert done.region.contains(done.fitted.phi).mean() > 0.95


@pytest.mark.parametrize("fraction", [0.0, 1.0])
def test_some_poses_are_fitted_and_some_are_left_to_judge(fraction):
    with pytest.raises(ValueError, match=f"between 0 and 1, got {fraction:g}"):
        CalibrationCfg(fraction=fraction)


def test_a_seed_draws_its_split(wavy_data):
    cfg = CalibrationCfg(joint_errors=JointErrors())
    first, again, other = (calibrate(ARM, wavy_data[:100], cfg, seed=s) for s in (0, 0, 1))
    np.testing.assert_array_equal(first.fitted.phi, again.fitted.phi)
    np.testing.assert_array_equal(first.geometry.x, again.geometry.x)
    assert not np.array_equal(first.fitted.phi, other.fitted.phi)


def test_outliers_are_listed_with_their_row_and_stay(wavy_data):
    points = wavy_data.points.copy()
    points[11, 0] += 0.02
    cfg = CalibrationCfg(joint_errors=JointErrors(), fraction=0.95)
    done = calibrate(ARM, replace(wavy_data, points=points), cfg)
    assert done.outliers[0].row == 12
    assert done.outliers[0].residual == pytest.approx(0.02 * np.sqrt(3), rel=0.1)
    assert done.fitted.row is not None
    assert 12 in done.fitted.row


def _phi(rows, motor, value):
    """Angles of a motor in some rows replaced."""

    def spoil(d):
        phi = d.phi.copy()
        phi[rows, motor] = value
        return replace(d, phi=phi)

    return spoil


def _shaken(*sizes):
    """Each target moved at random by a size [m] of its own."""

    def spoil(d):
        noise = np.random.default_rng(0).normal(size=d.points.shape)
        return replace(d, points=d.points + noise * np.reshape(sizes, (3, 1)))

    return spoil


WRONG = {
    "degrees": (lambda d: replace(d, phi=np.degrees(d.phi)), "are the angles in degrees"),
    "radians twice": (lambda d: replace(d, phi=np.radians(d.phi)), "angles taken for degrees"),
    "millimetres": (lambda d: replace(d, points=1e3 * d.points), "are they in millimetres"),
    "swapped": (lambda d: replace(d, phi=d.phi[:, [1, 0, 2, 3, 4, 5]]), "motors 1 and 2 swapped"),
    "sign": (lambda d: replace(d, phi=d.phi * [1, 1, -1, 1, 1, 1]), "sign of motor 3 reversed"),
    "nan": (_phi(4, 2, np.nan), "motor_angle_3 is not finite in row 6"),
    "few": (lambda d: d[np.arange(3)], "too few poses"),
    "still": (_phi(slice(None), 3, 0.2), "motor 4 does not move"),
    "inches": (lambda d: replace(d, points=d.points / 0.0254), "are they in inches"),
    "moving among imprecise": (_shaken(0, 0.005, 0.9e-3), "target 2 moves against the tool"),
    "moving target": (_shaken(0, 0.005, 0), "target 2 moves against the tool"),
    "noise": (_shaken(0.3, 0.3, 0.3), "targets move against each other"),
    "five motors": (lambda d: replace(d, phi=d.phi[:, :5]), "has 6 motors, the data have 5"),
}


@pytest.mark.parametrize("name", WRONG)
def test_data_that_cannot_be_right_are_named(name, measured):
    data = measured("irb120", 200, np.random.default_rng(0), errors=TRUTH, targets=3)
    data = data[(np.abs(data.phi[:, :2]) < 1.9).all(axis=1)]  # a swap keeps the limits
    spoil, message = WRONG[name]
    with pytest.raises(ValueError, match=message):
        check(*ARM, spoil(data))
    check(*ARM, data)


@pytest.mark.parametrize(
    ("axes", "signs", "said"),
    [
        ([1, 0, 2], [1, 1, 1], "x and y swapped"),
        ([0, 2, 1], [1, 1, 1], "y and z swapped"),
        ([2, 1, 0], [1, 1, 1], "x and z swapped"),
        ([0, 1, 2], [-1, 1, 1], "the sign of x reversed"),
        ([0, 1, 2], [1, 1, -1], "the sign of z reversed"),
    ],
)
def test_a_mirrored_frame_of_the_targets_is_named(axes, signs, said, measured):
    """Near the axes of the base, so that it is known which; a permuted right-handed frame fits."""
    data = measured("irb120", 200, np.random.default_rng(0), errors=TRUTH)
    near = Rotation.from_euler("ZYX", [0.2, 0.1, -0.1]).as_matrix()
    data = data.moved(near @ R_TRACKER.T, np.zeros(3))
    message = rf"do not fit .* mm with the frame of the targets mirrored, {said}"
    with pytest.raises(ValueError, match=message):
        check(*ARM, replace(data, points=data.points[..., axes] * signs))
    check(*ARM, replace(data, points=data.points[..., [1, 2, 0]]))


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        ((slice(None), 1), np.nan, "target 2 was never seen"),
        ((3, 0, 2), np.nan, "target 1 in row 4 has some coordinates and lacks others"),
        ((3, 1, 2), np.inf, "a target has an infinite coordinate"),
    ],
)
def test_what_is_missing_is_named_with_its_target_and_row(place, value, said):
    points = np.ones((5, 2, 3))
    _finite(Measurements(phi=np.zeros((5, 6)), points=points))
    points[place] = value
    with pytest.raises(ValueError, match=said):
        _finite(Measurements(phi=np.zeros((5, 6)), points=points))


def test_measurements_check_their_shapes():
    with pytest.raises(ValueError, match="points"):
        Measurements(phi=np.zeros((3, 6)), points=np.zeros((2, 1, 3)))
