"""The smoother on a schedule."""

import numpy as np
import pytest

from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process
from armside.ilc.estimation.scheduled import ScheduledSmoother


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
