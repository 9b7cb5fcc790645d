"""The non-causal Wiener filter where readings are missing."""

import numpy as np

from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process, sampled_noise, steady_state_covariance
from armside.ilc.estimation.wiener import NonCausal

STEP = 0.01
A = np.array([[0.0, 1.0], [-((2 * np.pi * 3) ** 2), -2.0]])
W = np.diag([0.0, 4.0])
C = np.array([[1.0, 0.0], [0.0, 0.1]])
R = 1e-4 * np.array([[1.0, 0.5], [0.5, 4.0]])


def test_a_wiener_filter_predicts_over_what_is_missing():
    """As the smoother with the same readings missing, far from the ends: rows, single channels."""
    Ad, Q = sampled_noise(A, W, STEP)
    process, rng = Process(A=Ad, Q=Q, C=C, R=R), np.random.default_rng(0)
    x, y = np.zeros(2), np.empty((1000, 2))
    for i in range(1000):
        y[i] = C @ x + rng.multivariate_normal(np.zeros(2), R)
        x = Ad @ x + rng.multivariate_normal(np.zeros(2), Q)
    y[400:410], y[500::7, 0], y[550::9, 1] = np.nan, np.nan, np.nan
    P = steady_state_covariance(process)
    smoothed = Smoother(process, P, np.isfinite(y))(y).smoothed[:, 0]
    wiener, zeros = (NonCausal(A, W, C, C[:1])(z, STEP, R)[:, 0] for z in (y, np.nan_to_num(y)))
    middle = slice(200, 800)
    left = [np.std(found[middle] - smoothed[middle]) for found in (wiener, zeros)]
    assert left[0] < 0.02 * np.std(smoothed[middle])
    assert left[0] < 0.2 * left[1]
