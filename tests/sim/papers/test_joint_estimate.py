"""Estimator of Chen and Tomizuka: its filter on known noise, its parts on an arm, and the job."""

from dataclasses import replace

import numpy as np
import pytest

from armside.ilc.estimation.kinematic import KinematicFilter
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.laser.experiment import prepare
from armside.sim.laser.strokes import Strokes, robot_of
from armside.sim.papers.joint_estimate import (
    ACCELEROMETER,
    BY_ALL,
    STEP,
    JointEstimator,
    signals,
    tool_positions,
)
from armside.sim.papers.two_stage import TwoStage

M16IB = "m16ib_like.toml"


def test_noise_is_found_and_a_smoother_beats_a_filter_and_both_the_rough_angle():
    rng, h, n = np.random.default_rng(0), 1e-3, 4000
    t = h * np.arange(n)
    truth, acceleration = 0.2 - 0.2 * np.cos(5.0 * t), 5.0 * np.cos(5.0 * t)  # from rest
    rough = truth + 1e-3 * rng.standard_normal(n)
    seen = acceleration + 0.5 * rng.standard_normal(n)
    kalman = KinematicFilter(step=h)
    by_all, by_past = kalman.smoothed(rough, seen)[:, 0], kalman.filtered(rough, seen, 500)[:, 0]
    off = [np.sqrt(np.mean((each - truth)[1000:] ** 2)) for each in (by_all, by_past, rough)]
    # Of a double integrator a smoother's variance is a quarter of a filter's, noise known.
    assert off[0] == pytest.approx(0.5 * off[1], rel=0.1)
    assert off[1] < 0.6 * off[2]


def test_a_causal_filter_does_not_see_the_future():
    rng = np.random.default_rng(1)
    rough, seen = 1e-3 * rng.standard_normal((2, 1500))
    later = rough.copy()
    later[900:] += 1.0
    kalman = KinematicFilter(step=1e-3)
    a, b = (kalman.filtered(each, seen, 500) for each in (rough, later))
    np.testing.assert_array_equal(a[:900], b[:900])
    assert np.abs(a[900:] - b[900:]).max() > 0.1


def test_a_known_motion_changes_no_noise_and_so_no_error_of_a_causal_filter():
    rng, kalman, n = np.random.default_rng(2), KinematicFilter(step=1e-3), 2000
    rough, seen = 1e-3 * rng.standard_normal(n), 0.5 * rng.standard_normal(n)
    pushed = np.where(np.arange(n) < 300, 5.0, 0.0)  # from then on at 1.5 rad/s
    A, B = kalman.process
    motion = np.zeros((n, 2))
    for i, u in enumerate(pushed[:-1]):
        motion[i + 1] = A @ motion[i] + B * u
    still = kalman.filtered(rough, seen, 500)
    moving = kalman.filtered(rough + motion[:, 0], seen + pushed, 500)
    np.testing.assert_allclose(moving - motion, still, atol=1e-6)


@pytest.fixture(scope="module")
def run():
    strokes = Strokes(robot=robot_of(M16IB), across_tool=True, individual=None, imu=ACCELEROMETER)
    experiment = prepare(strokes)
    return experiment, experiment.plant.run(np.zeros_like(experiment.loaded.reference))


def arm_of(experiment, factor=1.0):
    cfg = NominalCfg(stiffness=factor, damping=factor)
    return JointEstimator(experiment.nominal, nominal_arm(experiment.nominal, cfg))


def test_joint_angles_show_the_sag_that_motor_angles_hide(run):
    experiment, done = run
    seen, estimator = signals(experiment, done), arm_of(experiment)
    truth = done.recording.truth.every(round(STEP / float(done.recording.truth.time[1])))
    angle, acceleration = estimator.smoothed(seen)

    def off(q):
        return np.linalg.norm(tool_positions(estimator.arm, q) - truth.tool_position, axis=1)

    assert off(seen.motor_angle)[:400].mean() > 4e-4  # [m], at rest before the motion
    assert off(angle).mean() < 0.4 * off(seen.motor_angle).mean()
    load = np.gradient(
        np.gradient(truth.motor_angle + truth.flex_angle, STEP, axis=0), STEP, axis=0
    )
    missing = np.sqrt(np.mean((acceleration - load)[:, 1] ** 2) / np.mean(load[:, 1] ** 2))
    assert missing < 0.2  # of the second axis; 30 Hz of the smoother cuts the jerk


def test_a_model_that_is_twice_as_stiff_shows_half_of_the_twist(run):
    experiment, done = run
    seen = signals(experiment, done)
    twists = [
        seen.motor_angle - arm_of(experiment, factor).rough(seen, BY_ALL) for factor in (1.0, 2.0)
    ]
    np.testing.assert_allclose(twists[1], 0.5 * twists[0], atol=1e-12)


@pytest.mark.parametrize("changed", ["motor_angle", "torque", "acceleration"])
def test_later_samples_change_no_causal_estimate_before_them(run, changed):
    experiment, done = run
    seen, at = signals(experiment, done), 800
    later = getattr(seen, changed).copy()
    later[at:] += 1e-2 * np.arange(1.0, len(later) - at + 1.0)[:, None]
    a, b = (arm_of(experiment).filtered(s) for s in (seen, replace(seen, **{changed: later})))
    np.testing.assert_array_equal(a[:at], b[:at])
    assert np.abs(a[at:] - b[at:]).max() > 1e-6


def test_an_accelerometer_of_another_rate_is_refused(run):
    experiment, done = run
    late = type(done)(recording=done.recording, tracker=done.tracker, imu=None)
    with pytest.raises(ValueError, match="the accelerometer must have a sample every 1 ms"):
        signals(experiment, late)


def test_a_side_is_load_or_motor():
    with pytest.raises(ValueError, match="side must be load or motor, got 'tool'"):
        TwoStage("tool")
