"""Filters and smoothers on simulated processes with known states."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import chi2

from armside.ilc.estimation.consistency import bounds, whiteness
from armside.ilc.estimation.kalman import Smoother, SteadyStateFilter
from armside.ilc.estimation.process import (
    Process,
    exponential,
    first_order_hold,
    sampled_noise,
    steady_state_covariance,
)

STEP = 0.01
A = np.array([[0.0, 1.0], [-((2 * np.pi * 3) ** 2), -2.0]])
W = np.diag([0.0, 4.0])
C = np.array([[1.0, 0.0]])
R = np.array([[1e-4]])


@pytest.fixture(scope="module")
def process():
    Ad, Q = sampled_noise(A, W, STEP)
    return Process(A=Ad, Q=Q, C=C, R=R)


@pytest.fixture(scope="module")
def record(process):
    """States and readings of 4000 samples, from the steady-state distribution."""
    rng = np.random.default_rng(0)
    n = 4000
    noise = rng.multivariate_normal(np.zeros(2), process.Q, n)
    x = np.zeros((n, 2))
    for i in range(1, n):
        x[i] = process.A @ x[i - 1] + noise[i]
    return x, x @ C.T + 1e-2 * rng.standard_normal((n, 1))


def test_exponential_is_that_of_scipy():
    rng = np.random.default_rng(1)
    M = 30.0 * rng.standard_normal((12, 12))
    assert exponential(M) == pytest.approx(expm(M), rel=1e-9, abs=1e-9 * np.abs(expm(M)).max())


def test_units_of_the_states_cost_no_digits():
    """An oscillator whose velocity is counted in parts of 1e-9: torques beside angles are alike."""
    omega, step, unit = 300.0, 0.01, 1e9
    A = np.array([[0.0, 1.0 / unit], [-(omega**2) * unit, 0.0]])
    cos, sin = np.cos(omega * step), np.sin(omega * step)
    exact = np.array([[cos, sin / omega / unit], [-omega * sin * unit, cos]])
    assert exponential(A * step) == pytest.approx(exact, rel=1e-12, abs=0.0)
    units = np.diag([1.0, unit])
    intensity = np.diag([0.0, 2.0])
    A_plain = np.array([[0.0, 1.0], [-(omega**2), 0.0]])
    Ad, Qd = sampled_noise(A, units @ intensity @ units, step)
    Ad_plain, Qd_plain = sampled_noise(A_plain, intensity, step)
    assert Ad == pytest.approx(exact, rel=1e-12, abs=0.0)
    assert Qd == pytest.approx(units @ Qd_plain @ units, rel=1e-11, abs=0.0)
    assert Ad_plain == pytest.approx(np.linalg.inv(units) @ exact @ units, rel=1e-12, abs=0.0)


def test_sampled_noise_is_the_integral_of_the_spread(process):
    t = np.linspace(0.0, STEP, 2001)
    spread = np.array([expm(A * s) @ W @ expm(A * s).T for s in t])
    assert pytest.approx(np.trapezoid(spread, t, axis=0), rel=1e-5, abs=1e-15) == process.Q


def test_a_held_ramp_is_followed_exactly():
    """x' = -x + u with u = t: x = t - 1 + e^-t."""
    Ad, B0, B1 = first_order_hold(np.array([[-1.0]]), np.array([[1.0]]), 0.5)
    assert Ad * 0.0 + B0 * 0.0 + B1 * 0.5 == pytest.approx(0.5 - 1.0 + np.exp(-0.5))


def test_a_state_that_is_neither_seen_nor_stable_is_refused():
    blind = Process(A=np.diag([1.1, 0.5]), Q=np.eye(2), C=np.array([[0.0, 1.0]]), R=np.eye(1))
    with pytest.raises(RuntimeError, match="has no steady state"), np.errstate(all="ignore"):
        steady_state_covariance(blind)


@pytest.mark.parametrize(("growth", "expected"), [(1.1, 0.21), (1.5, 1.25), (-1.1, 0.21)])
def test_a_state_that_grows_without_noise_is_followed(growth, expected):
    """a^2 P R / (P + R) = P with Q = 0 and P > 0: P = (a^2 - 1) R."""
    one = np.ones((1, 1))
    grows = Process(A=growth * one, Q=0.0 * one, C=one, R=one)
    assert steady_state_covariance(grows)[0, 0] == pytest.approx(expected, rel=1e-9)
    steady = SteadyStateFilter(grows)
    assert abs(growth * (1.0 - steady.gain[0, 0])) < 1.0


def test_a_constant_without_noise_has_no_steady_gain():
    one = np.ones((1, 1))
    with pytest.raises(RuntimeError, match="has no steady state"):
        steady_state_covariance(Process(A=one, Q=0.0 * one, C=one, R=one))


def test_innovations_of_a_right_model_are_white_and_of_a_wrong_one_are_not(process, record):
    _, y = record
    right = SteadyStateFilter(process)
    W_right, _ = right.whitening
    e = right(y).innovation @ W_right.T
    verdict = whiteness(e)
    assert verdict.is_white
    assert verdict.rms == pytest.approx(1.0, abs=0.05)
    nis = np.square(e).sum(axis=1)
    low, high = bounds(len(nis), 1, confidence=0.99)
    assert low < nis.mean() < high

    Ad, Q = sampled_noise(A * np.array([[1.0, 1.0], [1.6, 1.0]]), W, STEP)
    wrong = SteadyStateFilter(Process(A=Ad, Q=Q, C=C, R=R))
    assert not whiteness(wrong(y).innovation @ wrong.whitening[0].T).is_white


def test_the_statistic_of_whiteness_is_that_of_ljung_and_box():
    """Ljung and Box (1978), (1.3): n (n + 2) sum_k r_k^2 / (n - k), chi-square of as many lags.

    With 30 samples and 10 lags the weights matter: they range from 1.07 to 1.6.
    """
    e, lags = np.random.default_rng(4).standard_normal(30), 10
    e[1:] += 0.5 * e[:-1]
    c = e - e.mean()
    r = [c[k:] @ c[:-k] / (c @ c) for k in range(1, lags + 1)]
    q = 30 * 32 * sum(r[k - 1] ** 2 / (30 - k) for k in range(1, lags + 1))
    assert whiteness(e[:, None], lags).p_value == pytest.approx(chi2.sf(q, lags), rel=1e-9)


def test_a_steady_filter_uses_the_channels_that_are_there():
    """One row with one of two channels missing, in steady state: as the smoother's forward pass."""
    rng = np.random.default_rng(5)
    one = Process(
        A=np.array([[0.9, 0.2], [0.0, 0.7]]),
        Q=np.diag([0.2, 0.1]),
        C=rng.standard_normal((2, 2)),
        R=np.array([[0.3, 0.1], [0.1, 0.2]]),
    )
    y, P = rng.standard_normal((3, 2)), steady_state_covariance(one)
    y[1, 0] = np.nan
    steady = SteadyStateFilter(one)(y).innovation
    exact = Smoother(one, P, np.isfinite(y))(y).innovation
    np.testing.assert_allclose(steady, exact, atol=1e-12)  # P is exact up to the row's end
    y[1, 1] = np.nan
    assert abs(SteadyStateFilter(one)(y).innovation[2] - steady[2]).min() > 1e-3


def test_a_reading_without_noise_is_followed_exactly():
    A, exact = np.array([[0.9, 0.1], [0.0, 0.8]]), np.zeros((1, 1))
    steady = SteadyStateFilter(Process(A=A, Q=np.eye(2), C=np.array([[1.0, 0.0]]), R=exact))
    assert steady.gain[0, 0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("field", "wrong"), [("Q", [[1.0, 0.5], [0.0, 1.0]]), ("R", [[-1.0]])], ids=["skew", "negative"]
)
def test_what_is_no_covariance_is_refused(process, field, wrong):
    with pytest.raises(ValueError, match=f"{field} must be symmetric, with variances >= 0"):
        replace(process, **{field: np.array(wrong)})


def test_a_smoother_refuses_what_does_not_fit_its_measurements(process):
    with pytest.raises(ValueError, match=r"seen must have shape \(N,\) or \(N, 1\)"):
        Smoother(process, np.eye(2), np.ones((10, 2), dtype=bool))
    with pytest.raises(ValueError, match=r"start_covariance must have shape \(2, 2\)"):
        Smoother(process, np.eye(3), np.ones(10, dtype=bool))
    y = np.zeros((10, 1))
    y[3] = np.nan
    with pytest.raises(ValueError, match="missing at sample 3, channel 0"):
        Smoother(process, np.eye(2), np.ones(10, dtype=bool))(y)


def test_a_smoother_refuses_a_record_of_another_length(process):
    smoother = Smoother(process, np.eye(2), np.ones(10, dtype=bool))
    with pytest.raises(ValueError, match=r"\(10, 1\)"):
        smoother(np.zeros((11, 1)))


@pytest.mark.parametrize("name", ["Q", "R"])
def test_a_process_refuses_values_that_do_not_fit(name):
    fields = {"A": np.eye(2), "Q": np.eye(2), "C": C, "R": R}
    with pytest.raises(ValueError, match=f"{name} must have shape"):
        Process(**fields | {name: np.eye(3)})


@pytest.mark.parametrize("change", [1e-3, -2e-2])
def test_a_filter_beside_another_is_that_of_its_process_to_second_order(process, change):
    """A drive of the noise, the dynamics and the reading that changes a little each."""
    near = SteadyStateFilter(process)
    factor = 1.0 + change
    other = Process(A=process.A * (1.0 - 0.1 * change), Q=process.Q * factor, C=C, R=R / factor)
    exact, found = SteadyStateFilter(other), near.beside(other)
    moved = np.abs(exact.gain - near.gain).max() / np.abs(near.gain).max()
    assert moved > 0.1 * abs(change)  # the one there was is no answer
    rest = np.abs(found.gain - exact.gain).max() / np.abs(near.gain).max()
    assert rest < 5.0 * change**2


@pytest.mark.parametrize("modes", ["together", "singular", "not finite"])
def test_a_filter_beside_another_is_solved_anew_where_modes_do_not_serve(modes, monkeypatch):
    """Three equal modes that are hardly seen, in a chain: eigenvectors fall together."""
    chain = 0.9 * np.eye(3) + np.eye(3, k=1)
    one = Process(A=chain, Q=np.eye(3), C=np.eye(1, 3), R=np.array([[1.0]]))
    near, other = SteadyStateFilter(one), replace(one, Q=1.01 * one.Q)
    if modes == "singular":
        monkeypatch.setattr(np.linalg, "eig", lambda F: (np.diag(F), np.ones_like(F)))
    elif modes == "not finite":
        monkeypatch.setattr(np.linalg, "eig", lambda F: (np.ones(len(F)), np.eye(len(F))))
    else:
        vars(near)["_recursion"] = chain
    expected = SteadyStateFilter(other).gain
    np.testing.assert_allclose(near.beside(other).gain, expected, rtol=1e-9)
