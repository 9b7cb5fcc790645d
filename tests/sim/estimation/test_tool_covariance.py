"""Parts of the tool's covariance beyond the filter: springs, encoders and gear errors."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armside import assets
from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.estimation.deflection import deflection
from armside.sim.estimation.elasticity import ArmParameters, nominal_elasticity, parameters_at
from armside.sim.estimation.estimator import ToolEstimator, tool_path
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.rigid_motion import ENCODER_FILTER, rigid_motion
from armside.sim.estimation.structure import with_structure
from armside.sim.estimation.tool_covariance import (
    encoder_variance,
    gear_variance,
    sensitivities,
    tool_covariance,
    tool_jacobian,
)
from armside.sim.instruments.encoder import quantise
from armside.sim.instruments.imu import ImuCfg
from armside.sim.robot.effects import gear_orders
from armside.sim.robot.model import load_model

LARGE = load_model(assets.LARGE_ROBOT_XML)
PERIOD = 0.004


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


@pytest.fixture(scope="module")
def known() -> ToolEstimator:
    """Two seconds in which each axis turns by 0.05 rad, from rest to rest."""
    arm = nominal_arm(with_structure(LARGE), NominalCfg(structure=True))
    time = np.arange(0.0, 2.0, PERIOD)
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.clip((time - 0.3) / 1.2, 0.0, 1.0))
    motion = rigid_motion(arm, time, 0.2 + 0.05 * ramp[:, None] * np.ones(6))
    found = ArmParameters(nominal_elasticity(LARGE, arm), 0.0, 0.05, np.zeros(3))
    return ToolEstimator(arm, found, ImuCfg(), motion)


def test_sensitivities_are_the_derivative_of_the_path_to_each_spring(known):
    motion, nominal, at = known.along, known.parameters.springs, -1
    J = tool_jacobian(motion)[:, :3]
    S = sensitivities(motion, nominal, np.zeros(20), J)
    step = np.zeros(20)
    step[int(nominal.axes[1])] = 0.02
    moved = [
        tool_path(motion, deflection(motion, parameters_at(nominal, sign * step).springs))
        for sign in (1.0, -1.0)
    ]
    difference = (moved[0] - moved[1])[at, :3] / 0.04
    assert S.shape == (len(motion.time), 3, 15)
    size = np.abs(difference).max()  # J is that of the rigid arm, within hundredths
    assert S[at, :, int(nominal.axes[1])] == pytest.approx(difference, abs=0.02 * size)


def test_the_covariance_is_that_of_draws_of_all_that_is_uncertain(known):
    """At rest gear errors are none; after 0.05 rad of each axis they are the largest part."""
    rng, draws = np.random.default_rng(4), 20_000
    motion, nominal, axes = known.along, known.parameters.springs, known.arm.axes
    slope = 0.01 * rng.normal(size=(20, 20))
    theta = slope @ slope.T
    fit: Any = SimpleNamespace(theta=np.zeros(20), covariance=theta)
    found = tool_covariance(known, fit, nominal, LARGE)
    J = tool_jacobian(motion)[:, :3]
    S = sensitivities(motion, nominal, np.zeros(20), J)
    amplitude, order = gear_orders(LARGE)
    phase = rng.uniform(0.0, 2.0 * np.pi, size=(draws, *order.shape))
    springs = rng.multivariate_normal(np.zeros(15), theta[:15, :15], draws)
    counts = rng.normal(size=(draws, 6)) * np.sqrt(encoder_variance(LARGE.drives, PERIOD))
    for at in (0, -1):
        turned = (motion.phi[at] - motion.phi[0])[:, None] * order
        gears = (amplitude * (np.sin(turned + phase) - np.sin(phase))).sum(axis=2)
        filtered = known.filter_covariance[known.place[at]]
        state = rng.multivariate_normal(np.zeros(3), filtered, draws)
        moved = state + springs @ S[at].T + (gears + counts) @ J[at][:, axes].T
        expected = np.cov(moved.T)
        assert found[at] == pytest.approx(expected, abs=0.05 * np.abs(expected).max())
    assert np.trace(found[-1]) > 10.0 * np.trace(found[0])
