"""What a prediction says of a first run, and when its correction is not used."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.twin.parameters import Block, Parameters
from armside.sim.twin.prediction import (
    Evidence,
    FirstCutPrediction,
    is_identified,
    objection,
    predicted,
)

INSIDE, AROUND, RESIDUAL = 2e-6, np.array([6e-6, 8e-6, 5e-6]), 5e-6


def of(residual=RESIDUAL, sensor="tracker", n_cuts=10):
    return Evidence(sensor=sensor, n_cuts=n_cuts, residual=residual)


def test_a_twin_that_is_the_robot_is_off_by_what_it_leaves_itself():
    found = predicted(1e-4, INSIDE, np.full(8, INSIDE), of(0.0))
    assert found.expected == pytest.approx(INSIDE)
    assert found.low < found.expected < found.high
    assert found.low > 0.0


@pytest.mark.parametrize(
    ("inside", "around", "residual"),
    [(2.0, 1.0, 1.0), (1.0, 2.0, 1.0), (1.0, 1.0, 2.0)],
    ids=["inside", "around", "residual"],
)
def test_each_sign_of_a_wrong_twin_raises_the_expected_error(inside, around, residual):
    before = predicted(1e-4, INSIDE, AROUND, of())
    after = predicted(1e-4, inside * INSIDE, around * AROUND, of(residual * RESIDUAL))
    assert after.expected > 1.05 * before.expected


def test_expected_errors_have_the_unit_of_what_they_are_made_of():
    before = predicted(1e-4, INSIDE, AROUND, of())
    after = predicted(1e-4, 3.0 * INSIDE, 3.0 * AROUND, of(3.0 * RESIDUAL))
    assert after.expected == pytest.approx(3.0 * before.expected)
    assert after.high_of_type == pytest.approx(3.0 * before.high_of_type)


def test_the_interval_is_that_of_the_sensor():
    by_tracker, by_imu = (predicted(1e-4, INSIDE, AROUND, of(sensor=s)) for s in ("tracker", "imu"))
    assert by_imu.expected == by_tracker.expected
    assert by_imu.high > by_tracker.high
    assert by_imu.high / by_imu.low > by_tracker.high / by_tracker.low


def test_the_interval_is_that_of_so_many_cuts_or_fewer():
    def ends(n_cuts, sensor="tracker"):
        found = predicted(1e-4, INSIDE, AROUND, of(sensor=sensor, n_cuts=n_cuts))
        return found.low, found.high

    each = [ends(n) for n in (2, 4, 10)]
    assert len(set(each)) == 3
    assert [ends(3), ends(9), ends(40)] == each
    assert ends(1) == ends(10)  # a single cut cannot be left out: no residual says too much
    assert ends(4, "imu") == ends(10, "imu")


@pytest.mark.parametrize(("sensor", "fewest"), [("tracker", 2), ("imu", 10)])
def test_of_fewer_cuts_than_it_was_fitted_to_an_interval_is_not_calibrated(sensor, fewest):
    for n in (fewest - 1, fewest):
        found = predicted(1e-4, INSIDE, AROUND, of(sensor=sensor, n_cuts=n))
        assert found.calibrated == (n == fewest)


def test_only_the_residual_of_a_tracker_loosens_the_springs_around_a_twin(twin):
    def around(sensor, residual):
        known = 1e-12 * twin.covariance
        one = replace(twin, sensor=sensor, held_out=np.full(2, residual), covariance=known)
        return np.array([member.gear_stiffness for member in one.around])

    assert np.array_equal(around("imu", 1e-6), around("imu", 50e-6))
    assert np.array_equal(around("imu", 1e-6), around("tracker", 0.0))
    loose, tight = (np.std(np.log(around("tracker", r)), axis=0) for r in (20e-6, 2e-6))
    assert loose == pytest.approx(10.0 * tight, rel=0.01)


def test_a_correction_that_may_leave_more_than_three_tenths_is_not_used():
    error = {"uncorrected": 1e-4, "inside": 1e-6, "expected": 2e-5, "low": 1e-5, "high": 5e-5}
    good = FirstCutPrediction(**error, high_of_type=2.99e-5, calibrated=True)
    assert objection(good) is None
    bad = replace(good, high_of_type=3.01e-5)
    assert "up to 30 % of the error would be left" in str(objection(bad))


@pytest.mark.parametrize("end", [np.nan, np.inf])
def test_a_correction_by_which_a_twin_becomes_unstable_is_not_used(end):
    """One unstable individual around it is enough."""
    found = predicted(1e-4, INSIDE, np.array([5e-6, end]), of())
    assert "unstable" in str(objection(found))


def test_an_interval_is_that_of_the_variances_by_hand():
    """In um: 2^2 + 0.4^2 (41.667 - 2^2) + 0.3^2 5^2 = 12.277, r = 3.5038; 0.53 r to 1.7 r."""
    found = predicted(1e-4, INSIDE, AROUND, of())
    ends = 1e6 * np.array([found.low, found.expected, found.high])
    np.testing.assert_allclose(ends, [1.8570, 3.5038, 5.9565], rtol=1e-4)


def test_cuts_that_no_parameter_explains_widen_the_upper_end_of_a_twin_of_ten():
    """In um, with 9 of the held-out cuts: r^2 = 17.317, 1.7 (r^2 + 1.4^2 (9^2 - 5^2))^1/2."""
    found = predicted(1e-4, INSIDE, AROUND, of(9e-6))
    ends = 1e6 * np.array([found.low, found.high_of_type, found.high])
    np.testing.assert_allclose(ends, [2.2055, 7.0744, 19.1641], rtol=1e-4)
    for sensor, n_cuts in (("tracker", 4), ("imu", 10)):
        other = predicted(1e-4, INSIDE, AROUND, of(9e-6, sensor, n_cuts))
        assert other.high == other.high_of_type


@pytest.mark.parametrize("part", [0.69, 0.71])
def test_the_cuts_tell_of_what_they_know_to_seven_tenths_of_its_prior(part):
    springs, places = Block("springs", (2,), 0.3), Block("places", (1,), 0.7e-3)
    found = np.diag(np.square([part * 0.3, 0.2 * 0.3, part * 0.7e-3]))
    known = is_identified(Parameters((springs, places)), found)
    assert known.tolist() == [part < 0.7, True, part < 0.7]
