"""Parts of the tool's covariance beyond the filter: springs, encoders and gear errors."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armside import assets
from armside.ilc.estimation.prediction_error import ParameterEstimate
from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.estimation.observer import ENCODER_FILTER
from armside.sim.estimation.tool_covariance import (
    encoder_variance,
    gear_variance,
    sensitivities,
    tool_covariance,
)
from armside.sim.instruments.encoder import quantise
from armside.sim.robot.drives import EXACT
from armside.sim.robot.effects import gear_orders
from armside.sim.robot.model import load_model

LARGE = load_model(assets.LARGE_ROBOT_XML)
PERIOD = 0.004

FIT = ParameterEstimate(
    theta=np.array([1.0, 1e-6]),
    covariance=np.diag([1.0, 1e-6]) ** 2,
    information=np.ones(2),
    cost=0.0,
    costs=(0.0,),
    innovation=np.zeros((5, 6)),
)


def test_sensitivities_are_the_derivative_of_a_path_at_the_scale_of_each_parameter():
    slope = np.random.default_rng(1).normal(size=(5, 3, 2))
    slope[:, :, 1] *= 1e6
    assert sensitivities(lambda theta: slope @ theta, FIT) == pytest.approx(slope, rel=1e-6)


def test_counts_leave_the_variance_that_low_passed_motor_angles_have_from_rest():
    """Slow motions over many counts from starts anywhere within one, as in a cut."""
    drives, rng = LARGE.drives, np.random.default_rng(2)
    time = np.arange(0.0, 4.0, PERIOD)
    motion = 0.02 * (1.0 - np.cos(np.pi * time)) ** 2
    low_pass, squares = ZeroPhaseButterworth(ENCODER_FILTER, PERIOD), list[float]()
    for start in rng.uniform(0.0, 1.0, size=40):
        angle = np.repeat((motion + start)[:, None], 2, axis=1)
        error = low_pass(quantise(angle, drives.encoder_counts, drives.gear[:2]) - angle)
        squares.append(float(np.square(error - error[0])[250:750, 0].mean()))
    assert encoder_variance(drives, PERIOD)[0] == pytest.approx(np.mean(squares), rel=0.3)


def test_angles_without_counts_are_exact_and_noise_adds_its_own():
    drives = LARGE.drives
    assert not encoder_variance(replace(drives, encoder_counts=0.0), PERIOD).any()
    rounded, noisy = (
        encoder_variance(replace(drives, encoder_noise=noise), PERIOD) for noise in (0.0, 1.0)
    )
    count = 2.0 * np.pi / drives.encoder_counts / np.abs(drives.gear)
    left = 2.0 * ENCODER_FILTER * PERIOD
    assert noisy - rounded == pytest.approx(left * count**2)


def test_gear_errors_of_any_phase_have_the_variance_of_random_ones():
    amplitude, order = gear_orders(LARGE)
    turned = np.array([0.0, 0.001, 0.02])
    phase = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, size=(20_000, 1, 4))
    errors = amplitude[0] * (np.sin(turned[:, None] * order[0] + phase) - np.sin(phase))
    expected = np.square(errors.sum(axis=2)).mean(axis=0)
    found = gear_variance(LARGE, np.repeat(turned[:, None], LARGE.n_axes, axis=1))[:, 0]
    assert found[0] == 0.0
    assert found == pytest.approx(expected, rel=0.05)


def test_the_covariance_is_that_of_draws_of_all_that_is_uncertain():
    """A tool moved by 8 states, 2 springs and 6 gears, at rest and after 0.05 rad of each axis.

    At rest gear errors are none, and the other parts of one size.
    """
    rng, draws = np.random.default_rng(4), 20_000
    T, slope = rng.normal(size=(6, 8)), 2e-6 * rng.normal(size=(2, 3, 2))
    turned, axes = np.array([[0.0] * 6, [0.05] * 6]), np.arange(1, 7)
    theta = replace(FIT, covariance=np.array([[1.0, 0.5], [0.5, 2.0]]))
    known: Any = SimpleNamespace(
        model=SimpleNamespace(tool=T, arm=SimpleNamespace(axes=axes)),
        arm=SimpleNamespace(gear_error=EXACT),
        clock_offset=0.0,
        smoother=lambda _: SimpleNamespace(
            smoothed_covariance=1e-12 * np.tile(np.eye(8), (2, 1, 1))
        ),
    )
    time = np.array([0.0, PERIOD])
    run: Any = SimpleNamespace(time=time, imu_time=time, period=PERIOD, phi=turned)
    found = tool_covariance(known, run, theta, lambda theta: slope @ theta, LARGE)

    amplitude, order = gear_orders(LARGE)
    phase = rng.uniform(0.0, 2.0 * np.pi, size=(draws, 1, *order.shape))
    gears = amplitude * (np.sin(turned[:, :, None] * order + phase) - np.sin(phase))
    counts = rng.normal(size=(draws, 2, 6)) * np.sqrt(encoder_variance(LARGE.drives, PERIOD))
    state, spring = (
        1e-6 * rng.normal(size=(draws, 2, 8)),
        rng.multivariate_normal(np.zeros(2), theta.covariance, draws),
    )
    state[:, :, axes] += gears.sum(axis=3) + counts
    moved = state @ T[:3].T + np.einsum("tij,nj->nti", slope, spring)
    for k in range(2):
        expected = np.cov(moved[:, k].T)
        assert found[k] == pytest.approx(expected, abs=0.05 * np.abs(expected).max())
