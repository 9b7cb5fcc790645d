"""The fit finds what was put in, and says how well it knows it."""

import os

import numpy as np
import pytest

from armside.kinematics import CATALOGUE, Link, Robot, compile
from armside.kinematics.calibration import (
    Choice,
    ErrorModel,
    JointErrors,
    Measurements,
    Priors,
    fit,
    identifiable,
)
from armside.kinematics.calibration.calibrate import corrected
from armside.kinematics.calibration.fit import (
    in_base,
    make_problem,
    normal_equations,
    residuals_and_jacobian,
)
from armside.kinematics.calibration.joint_errors import G, gravity_torques
from armside.kinematics.calibration.measurements import register
from armside.kinematics.calibration.plausibility import region

WEAK = Priors(length=1.0, angle=1.0, frame=10.0)
NOISE = 20e-6
DRAWS = 20 if os.environ.get("ARMSIDE_CI") else 8
TRUTH = {"theta_2": 1e-3, "a_2": -4e-4, "alpha_3": 8e-4, "beta_2": -6e-4, "d_5": 3e-4, "a_4": 2e-4}


@pytest.fixture(scope="module")
def model():
    return ErrorModel(CATALOGUE["irb120"].robot)


def test_the_identification_jacobian_is_the_difference_quotient(model, measured):
    data = measured("irb120", 6, np.random.default_rng(0), targets=2, rotation=True)
    registration = register(compile(model.robot).pose(data.phi), data)
    choice = Choice(("theta_2", "d_4", "a_3", "alpha_1", "beta_2"), JointErrors(2, True))
    own = in_base(registration, data)
    problem = make_problem(model, registration, own, choice, Priors())
    x = 0.3 * np.random.default_rng(1).normal(size=len(problem.scale))
    x[np.asarray(problem.scale) > 0.05] *= 0.01  # frames: the rotation vector is a first order one
    _, J = residuals_and_jacobian(problem, x, slice(0, 6))
    h = 1e-5

    def r(k, sign):
        step = np.zeros(len(x))
        step[k] = sign * h
        return residuals_and_jacobian(problem, x + step, slice(0, 6))[0]

    for k in range(len(x)):
        quotient = -(r(k, 1) - r(k, -1)) / (2 * h)
        size = max(np.abs(quotient).max(), 1e-6)
        np.testing.assert_allclose(J[:, :2, :, k], quotient[:, :2], rtol=0, atol=1e-5 * size)
        # Orientation: exact where the residual vanishes, of second order elsewhere.
        np.testing.assert_allclose(J[:, 2, :, k], quotient[:, 2], rtol=0, atol=2e-2 * size)


def test_gradient_and_hessian_are_those_of_the_cost(model, measured):
    data = measured("irb120", 20, np.random.default_rng(0), errors=TRUTH, noise=NOISE)
    registration = register(compile(model.robot).pose(data.phi), data)
    problem = make_problem(
        model, registration, in_base(registration, data), Choice(("theta_2", "a_2")), Priors()
    )
    x = 0.01 * np.ones(len(problem.scale))
    at = normal_equations(problem, x, 0.3e-3)
    for k in range(len(x)):
        step = 1e-6 * np.eye(len(x))[k]
        ends = [normal_equations(problem, x + sign * step, 0.3e-3) for sign in (1, -1)]
        assert at.gradient[k] == pytest.approx((ends[0].cost - ends[1].cost) / 2e-6, rel=1e-4)


def test_errors_without_noise_are_found_exactly(model, measured):
    data = measured("irb120", 60, np.random.default_rng(2), errors=TRUTH)
    found = fit(model, data, Choice(tuple(TRUTH)), Priors(length=1, angle=1, noise=1e-6))
    for name, value in TRUTH.items():
        assert found.state.errors[model.index(name)] == pytest.approx(value, abs=1e-8)


def test_the_exported_robot_moves_as_the_model_predicts(model, measured):
    data = measured("irb120", 30, np.random.default_rng(3), errors=TRUTH)
    e = np.zeros(len(model.names))
    for name, value in TRUTH.items():
        e[model.index(name)] = value
    longer = model.kinematics(model.variables(data.phi, e)).pose
    np.testing.assert_allclose(compile(corrected(model, e)).pose(data.phi), longer, atol=1e-13)


def test_truth_lies_in_the_confidence_intervals_at_their_rate(model, measured):
    """18 link parameters in each draw of noise: its intervals are dependent. The points that they
    predict elsewhere are off by as much as their standard deviation says."""
    names = identifiable(model, measured("irb120", 60, np.random.default_rng(0))).geometry
    inside, ratios = [], []
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        truth = dict(zip(names, rng.normal(0, 5e-4, len(names)), strict=True))
        data = measured("irb120", 60, rng, errors=truth, noise=NOISE)
        found = fit(model, data, Choice(names), WEAK)
        off = np.array([found.state.errors[model.index(n)] - truth[n] for n in names])
        own = slice(6, 6 + len(names))
        inside += (np.abs(off) < 1.96 * found.standard_deviations[own]).tolist()
        elsewhere = measured("irb120", 50, rng, errors=truth)
        missed = np.linalg.norm(found.residuals(elsewhere)[:, 0], axis=1)
        ratios.append(missed / region(found, found).standard_deviation(elsewhere.phi))
    # 95 %; three standard errors of a rate from draws of strongly dependent intervals
    assert 0.90 < np.mean(inside) < 0.99
    # 18 directions in each draw: three standard errors of the root mean square are 0.2
    assert 0.8 < np.sqrt(np.mean(np.square(ratios))) < 1.2


def test_deviations_are_those_of_the_data_where_priors_are_wide(model, measured):
    data = measured("irb120", 60, np.random.default_rng(10), errors=TRUTH, noise=NOISE)
    wide, wider = (
        fit(model, data, Choice(tuple(TRUTH)), Priors(length=x, angle=x, frame=10.0, noise=NOISE))
        for x in (0.5, 1.0)
    )
    np.testing.assert_allclose(wide.standard_deviations, wider.standard_deviations, rtol=1e-3)


def test_a_wrong_measurement_keeps_a_bounded_pull(model, measured):
    data = measured("irb120", 80, np.random.default_rng(4), errors=TRUTH, noise=NOISE)
    points = data.points.copy()
    points[7] += 0.05
    worse = fit(model, Measurements(phi=data.phi, points=points), Choice(tuple(TRUTH)), WEAK)
    clean = fit(model, data, Choice(tuple(TRUTH)), WEAK)
    change = worse.x[6:12] - clean.x[6:12]
    assert np.abs(change * worse.problem.scale[6:12]).max() < 1e-4  # 50 mm move them by < 0.1 mm
    assert int(worse.lengths[:, 0].argmax()) == 7


def test_a_target_that_was_not_seen_counts_for_nothing(model, measured):
    data = measured("irb120", 40, np.random.default_rng(5), errors=TRUTH, targets=3)
    points = data.points.copy()
    points[::3, 1] = np.nan
    found = fit(
        model,
        Measurements(phi=data.phi, points=points),
        Choice(tuple(TRUTH)),
        Priors(length=1, angle=1, noise=1e-6),
    )
    assert found.state.errors[model.index("a_2")] == pytest.approx(TRUTH["a_2"], abs=1e-8)


def test_orientation_serves_where_a_point_on_the_last_axis_does_not():
    """A target on axis 6 does not feel joint 6; the tool's orientation does."""
    robot, limits = CATALOGUE["ur10"]
    model = ErrorModel(robot)
    phi = np.random.default_rng(6).uniform(limits.lower, limits.upper, (80, 6))
    T = compile(robot).pose(phi)
    p = (T[:, :3, 3] + 0.09 * T[:, :3, 2])[:, None]
    weak = identifiable(model, Measurements(phi=phi, points=p)).all
    both = identifiable(model, Measurements(phi=phi, points=p, rotation=T[:, :3, :3])).all
    assert weak.rank == 27 - 2
    assert both.rank == 30
    assert both.smallest > 1e-3


def test_harmonics_of_a_joint_are_found(model, measured):
    wave = np.array([0, 2e-4, 0, 0, 0, 0])
    data = measured(
        "irb120", 200, np.random.default_rng(7), joint=lambda phi: wave * np.sin(5 * phi + 0.3)
    )
    found = fit(model, data, Choice((), JointErrors(6)), Priors(harmonic=1e-3, noise=1e-6))
    value = dict(zip(found.problem.names[-72:], found.state.joint, strict=True))
    # The joint variable is phi - pi/2: sin(5 (q + pi/2) + 0.3) = sin(5 q + 5 pi/2 + 0.3).
    assert value["joint_2 sin 5"] == pytest.approx(2e-4 * np.cos(5 * np.pi / 2 + 0.3), abs=1e-6)
    assert value["joint_2 cos 5"] == pytest.approx(2e-4 * np.sin(5 * np.pi / 2 + 0.3), abs=1e-6)
    assert max(abs(v) for name, v in value.items() if "joint_2" not in name) < 2e-6


def test_compliance_is_found_by_its_torque(model, measured):
    from armside.kinematics.calibration.joint_errors import gravity_torques

    def sag(phi):
        torque = gravity_torques(model.robot, model.robot.joint_variables(phi), list(range(6)))
        names = [(i, k) for i in range(1, 7) for k in range(i + 1, 8)]
        out = np.zeros_like(phi)
        out[:, 1] = 5e-5 * torque[:, names.index((2, 4))]
        return out

    data = measured("irb120", 150, np.random.default_rng(8), joint=sag)
    choice = Choice((), JointErrors(0, True))
    rigid = fit(model, data, Choice(), Priors(noise=1e-5))
    soft = fit(model, data, choice, Priors(compliance=1e-2, noise=1e-6))
    fresh = measured("irb120", 50, np.random.default_rng(9), joint=sag)
    assert np.abs(rigid.residuals(fresh)).max() > 5e-5
    assert np.abs(soft.residuals(fresh)).max() < 1e-6


ARM = Robot((Link(alpha=np.pi / 2), Link(a=0.5), Link(a=0.3)), name="upright planar arm")
"""A vertical axis, and two horizontal ones whose positive angles lift the arm."""


@pytest.mark.parametrize("heading", [0.0, 1.0])
def test_a_weight_turns_an_axis_down_by_its_horizontal_distance(heading):
    q = np.array([[heading, 0.0, 0.0], [heading, np.pi / 3, 0.0], [heading, np.pi / 3, 0.2]])
    found = gravity_torques(ARM, q, [0, 1, 2])
    elbow, tool = 0.5 * np.cos(q[:, 1]), 0.3 * np.cos(q[:, 1] + q[:, 2])
    about_shoulder = np.stack([0.0 * elbow, -G * elbow, -G * (elbow + tool)], axis=1)
    # axis 1: frames 2, 3 and tool; axis 2: frame 3 and tool; axis 3: tool
    expected = np.column_stack([np.zeros((3, 3)), about_shoulder[:, 1:], -G * tool])
    np.testing.assert_allclose(found, expected, atol=1e-12)
