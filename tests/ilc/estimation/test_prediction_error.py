"""The prediction-error method recovers parameters and their uncertainty from innovations."""

import numpy as np
import pytest

from armside.ilc.estimation.kalman import SteadyStateFilter
from armside.ilc.estimation.prediction_error import Whitened, estimate_parameters
from armside.ilc.estimation.process import Process, sampled_noise

STEP, N = 0.01, 1500


def process(theta):
    """An oscillator; theta: logs of stiffness and damping over nominal."""
    A = np.array([[0.0, 1.0], [-300.0 * np.exp(theta[0]), -2.0 * np.exp(theta[1])]])
    Ad, Q = sampled_noise(A, np.diag([0.0, 4.0]), STEP)
    return Process(A=Ad, Q=Q, C=np.array([[1.0, 0.0]]), R=np.array([[1e-4]]))


def record(seed, theta):
    rng = np.random.default_rng(seed)
    p, x, y = process(theta), np.zeros(2), np.empty((N, 1))
    noise = rng.multivariate_normal(np.zeros(2), p.Q, N)
    for i in range(N):
        y[i] = x[0] + 1e-2 * rng.standard_normal()
        x = p.A @ x + noise[i]
    return y


def fitted(y):
    def model(theta):
        steady = SteadyStateFilter(process(theta))
        W, log_det = steady.whitening
        return Whitened(steady(y).innovation @ W.T, log_det)

    starts = [np.zeros(2), np.array([0.4, 0.0]), np.array([-0.4, 0.0])]
    return estimate_parameters(model, np.zeros(2), np.array([0.5, 1.0]), starts)


def test_errors_of_the_parameters_are_as_large_as_said():
    """Twelve records: normalised errors squared average to the number of parameters."""
    true = np.array([0.3, -0.4])
    nees = []
    for seed in range(12):
        found = fitted(record(seed, true))
        error = found.theta - true
        nees.append(error @ np.linalg.solve(found.covariance, error))
    assert np.mean(nees) == pytest.approx(2.0, abs=1.7)  # 3 sigma of a mean of 12


def test_parameters_without_information_keep_their_prior():
    def model(theta):
        return Whitened(np.array([[theta[0] - 1.0]] * 100) / 0.1, 2.0 * np.log(0.1))

    found = estimate_parameters(model, np.zeros(2), np.ones(2), [np.zeros(2)])
    assert found.theta == pytest.approx([1.0, 0.0], abs=1e-3)
    assert found.information == pytest.approx([1.0, 0.0], abs=1e-3)


def test_a_prediction_error_without_a_finite_value_is_an_error():
    with pytest.raises(RuntimeError, match="not finite"):
        estimate_parameters(
            lambda theta: Whitened(np.full((10, 1), np.inf), 0.0),
            np.zeros(1),
            np.ones(1),
            [np.zeros(1)],
        )
