"""Search for the springs: derivatives by the filter's own, against a whole filter for each."""

from collections import Counter

import numpy as np
import pytest
from tests.claims._estimates import path_error
from tests.conftest import WHOLE

from armside.assets import LARGE_ROBOT_XML
from armside.ilc.estimation import kalman, prediction_error
from armside.sim.estimation import identification
from armside.sim.estimation.elasticity import nominal_elasticity
from armside.sim.estimation.imu_health import repaired
from armside.sim.estimation.rigid_motion import rigid_motion
from armside.sim.instruments.imu import ImuCfg
from armside.sim.laser import Cut, ToolPath, prepare
from armside.sim.laser.loop import first_run
from armside.sim.robot.model import load_model

from .one_cut import IMU, assumed

DRAWN = [("p1", 120), ("p2", 121), ("p3", 122)]
"""Seeds on which nothing was chosen."""


def commissioned(pose, seed):
    experiment, measure = prepare(Cut(pose=pose, imu=ImuCfg()), seed=seed), ToolPath()
    run = first_run(experiment)
    return run, measure.commissioned(experiment, measure.assumed(experiment), run)


@pytest.fixture
def whole_filters(monkeypatch):
    """The search as it was: each difference takes a Riccati equation of its own."""

    def as_it_was(model, prior, sd, starts, further=(), beside=None):
        return prediction_error.estimate_parameters(model, prior, sd, starts, further)

    return lambda: monkeypatch.setattr(identification, "estimate_parameters", as_it_was)


@pytest.mark.parametrize(("pose", "seed"), DRAWN if WHOLE else DRAWN[2:])
def test_the_search_ends_where_it_did_with_a_filter_for_each_difference(pose, seed, whole_filters):
    """The cost is rough on the scale of 10, as gears enter their lost motion and leave it: searches
    that round differently end that near to each other, and the paths within a tenth."""
    run, now = commissioned(pose, seed)
    whole_filters()
    run, before = commissioned(pose, seed)
    costs = [each.known.identified.fit.cost for each in (now, before)]
    assert costs[0] == pytest.approx(costs[1], abs=30.0)  # wrong minima lie hundreds above
    errors = [path_error(each(run), run) for each in (now, before)]
    assert errors[0] == pytest.approx(errors[1], rel=0.1)


def test_derivatives_are_those_of_whole_filters_and_solve_no_equation_of_their_own(
    first_model, monkeypatch
):
    model, sd = first_model
    solved = Counter()
    riccati = kalman.steady_state_covariance

    def counted(process):
        solved["riccati"] += 1
        return riccati(process)

    monkeypatch.setattr(kalman, "steady_state_covariance", counted)
    rng = np.random.default_rng(5)
    for theta in 0.5 * sd * rng.standard_normal((3, len(sd))):
        found = []
        for beside in (model.beside, lambda at, step: model(at + step)):
            problem = prediction_error._Problem(model, beside, 0.0 * sd, sd)
            solved.clear()
            _, information, gradient = prediction_error._linearised(problem, theta)
            found.append((information, gradient * sd, solved["riccati"]))
        (H, g, few), (H_whole, g_whole, many) = found
        assert few == 1 < 15 <= many  # springs, damping and process noise move the filter
        # Differences are right to their step, 1e-4 of a standard deviation.
        scale = np.sqrt(np.diag(H_whole))
        assert np.abs((H - H_whole) / np.outer(scale, scale)).max() < 1e-3
        assert g == pytest.approx(g_whole, rel=1e-3, abs=1e-4 * np.abs(g_whole).max())


@pytest.fixture
def first_model(first, monkeypatch):
    """Innovations of a cut, and the prior's standard deviations."""
    stopped = []

    def stop(model, prior, sd, *_):
        stopped.append((model, sd))
        raise StopIteration

    monkeypatch.setattr(identification, "estimate_parameters", stop)
    arm, log = assumed(), first.recording
    motion = rigid_motion(arm, log.time, log.motor_angle)
    nominal = nominal_elasticity(load_model(LARGE_ROBOT_XML), arm)
    with pytest.raises(StopIteration):
        identification.identify(motion, nominal, repaired(first.imu, IMU), IMU)
    return stopped[0]


def test_springs_far_beyond_any_arm_are_impossible_and_end_no_search(first_model):
    """A step of the search may try them: |A| h of 2^64 and more had no number of doublings."""
    model, sd = first_model
    for size in (60.0, 300.0):  # log stiffness and damping
        theta = np.zeros(len(sd))
        theta[: len(sd) - 8] = size
        innovation = model(theta).innovation
        assert not np.isfinite(innovation).any()
