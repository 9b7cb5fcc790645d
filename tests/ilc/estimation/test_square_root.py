"""The square-root smoother is the smoother, and holds where the covariance form does not."""

import warnings

import mpmath
import numpy as np
import pytest

from armside.ilc.estimation.kalman import Smoother
from armside.ilc.estimation.process import Process
from armside.ilc.estimation.square_root import smooth_square_root


def test_it_is_the_smoother_with_exact_states_and_single_channels_missing():
    rng = np.random.default_rng(0)
    one = Process(
        A=np.array([[0.9, 0.2, 0.1], [0.0, 1.0, 0.0], [0.3, 0.0, 0.5]]),
        Q=np.diag([0.2, 0.0, 0.1]),
        C=rng.standard_normal((2, 3)),
        R=np.array([[0.3, 0.1], [0.1, 0.2]]),
    )
    y, start, S = rng.standard_normal((30, 2)), rng.standard_normal(3), np.diag([1.0, 0.7, 0.0])
    y[2], y[4, 0], y[5, 1], y[29] = np.nan, np.nan, np.nan, np.nan
    plain = Smoother(one, S @ S.T, np.isfinite(y))
    expected, found = plain(y, start), smooth_square_root(one, y, start, S)
    np.testing.assert_allclose(found.innovation, expected.innovation, atol=1e-12)
    np.testing.assert_allclose(found.innovation_covariance, expected.innovation_covariance)
    np.testing.assert_allclose(found.filtered, expected.filtered, atol=1e-12)
    np.testing.assert_allclose(found.smoothed, expected.smoothed, atol=1e-12)
    np.testing.assert_allclose(found.filtered_covariance, plain.filtered_covariance, atol=1e-12)
    np.testing.assert_allclose(found.smoothed_covariance, plain.smoothed_covariance, atol=1e-12)
    assert found.smoothed_covariance[0, 2, 2] == 0.0


def stiff(n_samples=6):
    """A drift of 1e-12 seen beside a position, both to 1e-9 of what is known at the start."""
    one = Process(
        A=np.array([[1.0, 1e-2], [0.0, 1.0]]),
        Q=np.diag([1e-16, 1e-12]),
        C=np.array([[1.0, 1.0 + 1e-7]]),
        R=np.array([[1e-18]]),
    )
    y = 1e-4 * np.sin(np.arange(n_samples))[:, None]
    return one, y, np.diag([1.0, 1e2])


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


def test_variances_hold_where_the_covariance_form_has_none():
    one, y, S = stiff()
    mean, variance = dense(one, y, S @ S.T)
    found = smooth_square_root(one, y, np.zeros(2), S)
    said = np.diagonal(found.smoothed_covariance, axis1=1, axis2=2)
    np.testing.assert_allclose(said, variance, rtol=1e-5)
    np.testing.assert_allclose(found.smoothed, mean, atol=1e-2 * np.sqrt(variance.min()))
    with pytest.warns(RuntimeWarning, match="use square_root.smooth_square_root"):
        plain = Smoother(one, S @ S.T, np.ones(len(y), dtype=bool)).smoothed_covariance
    wrong = np.abs(np.diagonal(plain, axis1=1, axis2=2) / variance - 1.0)
    assert wrong.max() > 0.1


@pytest.mark.parametrize("seed", range(60))
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


def test_readings_without_noise_are_no_reason_to_warn():
    one, y, S = stiff()
    exact = Process(A=one.A, Q=one.Q, C=one.C, R=np.zeros((1, 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Smoother(exact, S @ S.T, np.ones(len(y), dtype=bool))


def test_what_has_no_square_root_or_does_not_fit_is_refused():
    one, y, S = stiff()
    exact = Process(A=one.A, Q=one.Q, C=one.C, R=np.zeros((1, 1)))
    with pytest.raises(ValueError, match="R must be positive definite"):
        smooth_square_root(exact, y, np.zeros(2), S)
    with pytest.raises(ValueError, match="must fit 1 readings, 2 states"):
        smooth_square_root(one, y, np.zeros(3), S)
