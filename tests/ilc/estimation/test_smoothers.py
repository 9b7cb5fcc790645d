"""Smoothers: scheduled, for stiff records; compiled once."""

import os
import warnings

import mpmath
import numpy as np
import pytest

from armside.arrays import read_only
from armside.ilc.estimation import kalman
from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process
from armside.ilc.estimation.scheduled import ScheduledSmoother


def test_arrays_that_may_be_written_to_and_others_share_one_smoother():
    matrix = np.eye(2)
    process = Process(A=0.9 * matrix, Q=matrix, C=matrix, R=matrix)
    found = [
        kalman.Smoother(process, start, seen).filtered_covariance
        for start in (matrix, read_only(matrix), np.asfortranarray(matrix))
        for seen in (np.ones(3, dtype=bool), np.ones((3, 2), dtype=bool))
    ]
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])
    assert len(kalman._covariances.signatures) == 1


def test_what_is_read_only_shares_its_memory_and_leaves_the_array_as_it_was():
    array = np.zeros((2, 3))
    view = read_only(array)
    assert np.shares_memory(view, array)
    assert not view.flags.writeable
    assert array.flags.writeable
    assert read_only(array.T).flags.c_contiguous


def process(frequency: float) -> Process:
    """A damped oscillator that is shaken, its position read."""
    A = 0.98 * np.array(
        [[np.cos(frequency), np.sin(frequency)], [-np.sin(frequency), np.cos(frequency)]]
    )
    return Process(A=A, Q=0.1 * np.eye(2), C=np.array([[1.0, 0.0]]), R=np.array([[0.5]]))


def record(processes: list[Process], n: int, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng, x, states, readings = np.random.default_rng(seed), np.zeros(2), [], []
    for i in range(n):
        one = processes[i * len(processes) // n]
        x = one.A @ x + rng.multivariate_normal(np.zeros(2), one.Q)
        states.append(x)
        readings.append(one.C @ x + rng.normal(0.0, np.sqrt(one.R[0, 0]), 1))
    return np.array(states), np.array(readings)


def test_of_one_process_it_is_the_kalman_smoother_away_from_the_ends():
    one = process(0.3)
    _, y = record([one], 200)
    exact = Smoother(one, np.eye(2), np.ones(200, dtype=bool))(y)
    found = ScheduledSmoother([one], np.zeros(200, dtype=int))(y, np.zeros(2))
    assert np.abs(found.smoothed - exact.smoothed)[80:-40].max() < 1e-6


def test_its_covariance_is_that_of_the_kalman_smoother():
    one = process(0.3)
    exact = Smoother(one, np.eye(2), np.ones(200, dtype=bool)).smoothed_covariance[100]
    found = ScheduledSmoother([one], np.zeros(0, dtype=int)).smoothed_covariance[0]
    assert found == pytest.approx(exact, abs=1e-6)  # its recursion ends at changes of 1e-6


def test_a_schedule_beats_a_single_process_where_the_process_changes():
    both = [process(0.2), process(0.8)]
    states, y = record(both, 1000)
    schedule = np.repeat([0, 1], 500)
    along = ScheduledSmoother(both, schedule)(y, np.zeros(2)).smoothed
    single = ScheduledSmoother(both[:1], np.zeros(1000, dtype=int))(y, np.zeros(2)).smoothed
    errors = [np.square(found - states)[510:].mean() for found in (along, single)]
    assert errors[0] < 0.7 * errors[1]


def test_missing_readings_are_predicted_over():
    one = process(0.3)
    states, y = record([one], 200)
    y[90:100] = np.nan
    found = ScheduledSmoother([one], np.zeros(200, dtype=int))(y, np.zeros(2))
    assert np.isnan(found.innovation[90:100]).all()
    assert np.isfinite(found.smoothed).all()
    assert np.abs(found.smoothed - states).max() < 5.0


def two_channels() -> Process:
    """The oscillator, its position read twice: one reading is bad, their noises are correlated."""
    one, C = process(0.3), np.array([[1.0, 0.0], [0.5, 1.0]])
    return Process(A=one.A, Q=one.Q, C=C, R=np.array([[0.5, 0.2], [0.2, 2.0]]))


@pytest.mark.parametrize("channel", [0, 1])
def test_a_missing_channel_costs_no_row(channel):
    """One row with a channel missing: nearly the Kalman smoother, which is unsteady after it."""
    one, rng = two_channels(), np.random.default_rng(5)
    y = rng.standard_normal((200, 2))
    y[100, channel] = np.nan
    exact = Smoother(one, np.eye(2), np.isfinite(y))
    expected = exact(y)
    found = ScheduledSmoother([one], np.zeros(200, dtype=int))(y, np.zeros(2))
    there = 1 - channel
    scale = np.sqrt(expected.innovation_covariance[100, there, there])
    white = expected.innovation[100, there] / scale
    assert found.innovation[100, there] == pytest.approx(white, abs=1e-6)
    assert np.isnan(found.innovation[100, channel])
    sd = np.sqrt(np.diag(exact.smoothed_covariance[100]))
    assert (np.abs(found.smoothed[100] - expected.smoothed[100]) < 0.1 * sd).all()
    y[100] = np.nan
    blind, near = ScheduledSmoother([one], np.zeros(200, dtype=int))(y, np.zeros(2)), slice(60, 140)
    apart, left = (np.abs(each.smoothed - expected.smoothed)[near].max() for each in (blind, found))
    assert left < 0.5 * apart


def dense(process, y, P0):
    """Mean and covariance of the joint Gaussian of all states, in sixty digits."""
    with mpmath.workdps(60):
        A, Q, C, R, P = (
            mpmath.matrix(m.tolist()) for m in (process.A, process.Q, process.C, process.R, P0)
        )
        n, N = len(P0), len(y)
        cov = mpmath.zeros(n * N)
        for i in range(N):
            block = P.copy()
            for j in range(i, N):
                cov[n * j : n * j + n, n * i : n * i + n] = block
                cov[n * i : n * i + n, n * j : n * j + n] = block.T
                block = A * block
            P = A * P * A.T + Q
        H = mpmath.zeros(N, n * N)
        for i in range(N):
            H[i, n * i : n * i + n] = C
        S = H * cov * H.T + R[0, 0] * mpmath.eye(N)
        K = (mpmath.inverse(S) * (H * cov)).T
        mean, after = K * mpmath.matrix(y.tolist()), cov - K * H * cov
        variance = [float(after[i, i]) for i in range(n * N)]
        return np.array([float(v) for v in mean]).reshape(N, n), np.reshape(variance, (N, n))


@pytest.mark.parametrize("seed", range(60 if os.environ.get("ARMSIDE_CI") else 15))
def test_the_covariance_form_is_right_or_warns(seed):
    """Variances up to 1e28 apart; the smallest variances lose most."""
    rng = np.random.default_rng(seed)
    n, decades = int(rng.integers(1, 4)), rng.uniform(0, 14)
    A = rng.standard_normal((n, n))
    one = Process(
        A=0.95 * A / np.abs(np.linalg.eigvals(A)).max(),
        Q=np.diag(10.0 ** rng.uniform(-1.5 * decades, -0.5 * decades, n)),
        C=rng.standard_normal((1, n)),
        R=np.array([[10.0**-decades]]),
    )
    P0 = np.diag(10.0 ** rng.uniform(0, decades, n))
    y, seen = rng.standard_normal((6, 1)), np.ones(6, dtype=bool)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        plain = Smoother(one, P0, seen)
    mean, variance = dense(one, y, P0)
    found = np.diagonal(plain.smoothed_covariance, axis1=1, axis2=2)
    off = np.abs(plain(y).smoothed - mean) / np.sqrt(variance)
    assert said or (np.abs(found / variance - 1.0).max() < 1e-2 and off.max() < 1e-4)
    assert not said or decades > 3.0


def test_variances_too_far_apart_are_said_unless_readings_have_no_noise():
    """A drift of 1e-12 seen beside a position, both to 1e-9 of what is known at the start."""
    A, Q, start = np.array([[1.0, 1e-2], [0.0, 1.0]]), np.diag([1e-16, 1e-12]), np.diag([1.0, 1e4])
    C, seen = np.array([[1.0, 1.0 + 1e-7]]), np.ones(6, dtype=bool)
    with pytest.warns(RuntimeWarning, match="too far apart for Smoother"):
        Smoother(Process(A=A, Q=Q, C=C, R=np.array([[1e-18]])), start, seen)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Smoother(Process(A=A, Q=Q, C=C, R=np.zeros((1, 1))), start, seen)
