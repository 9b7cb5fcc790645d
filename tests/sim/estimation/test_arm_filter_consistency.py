"""The arm's filter is consistent on records of its own model: NIS and NEES cover the truth."""

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.ilc.estimation.consistency import bounds, normalised_squared
from armside.ilc.estimation.kalman import Smoother
from armside.sim.estimation.arm_filter import arm_filter
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import nominal_arm
from armside.sim.instruments.imu import ImuCfg
from armside.sim.robot.model import load_model

from .extended_arm import start_covariance

REST = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
RECORDS, SAMPLES = 60, 120
CONFIDENCE = (
    0.999  # of each interval: one test in a thousand would fail by chance, the seed is fixed
)


def root(covariance):
    """A matrix S with S S^T = covariance, also of one that is singular."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    value, vector = np.linalg.eigh(covariance / np.outer(scale, scale))
    return scale[:, None] * vector * np.sqrt(np.maximum(value, 0.0))


@pytest.fixture(scope="module")
def records():
    """Filter, and for each record its states and what the smoother makes of its readings."""
    imu = ImuCfg()
    model = arm_filter(linearised(nominal_arm(load_model(LARGE_ROBOT_XML)), REST), imu)
    process, P = model.sampled(1.0 / imu.rate), start_covariance(model)
    smoother = Smoother(process, P, np.ones(SAMPLES, dtype=bool))
    first, noise, reading = root(P), root(process.Q), root(process.R)
    rng, found = np.random.default_rng(0), []
    for _ in range(RECORDS):
        x = np.empty((SAMPLES, len(P)))
        x[0] = first @ rng.standard_normal(len(P))
        for i in range(1, SAMPLES):
            x[i] = process.A @ x[i - 1] + noise @ rng.standard_normal(len(P))
        y = x @ process.C.T + rng.standard_normal((SAMPLES, 6)) @ reading.T
        found.append((x, smoother(y)))
    return model, smoother, found


def test_nis_of_the_arm_filter_is_that_of_white_innovations(records):
    _, _, found = records
    nis = [normalised_squared(s.innovation, s.innovation_covariance).mean() for _, s in found]
    low, high = bounds(RECORDS * SAMPLES, 6, CONFIDENCE)
    assert low < np.mean(nis) < high


@pytest.mark.parametrize("at", [SAMPLES // 2, SAMPLES - 1])
@pytest.mark.parametrize("kind", ["filtered", "smoothed"])
def test_nees_of_the_tool_covers_the_truth(records, kind, at):
    """Errors of one record are correlated in time: one instant of each record."""
    model, smoother, found = records
    T = model.tool[:3]
    P = T @ getattr(smoother, f"{kind}_covariance")[at] @ T.T
    errors = np.array([T @ (getattr(s, kind)[at] - x[at]) for x, s in found])
    low, high = bounds(RECORDS, 3, CONFIDENCE)
    assert low < normalised_squared(errors, P[None]).mean() < high


def test_a_lost_channel_costs_less_than_the_row(records):
    """Variance of the tool after half a second without one gyro axis, and without all channels."""
    model, smoother, _ = records
    T, variance = model.tool[:3], []
    for lost in ([], [5], range(6)):
        seen = np.ones((SAMPLES, 6), dtype=bool)
        seen[SAMPLES // 2 :, lost] = False
        P = Smoother(smoother.process, start_covariance(model), seen).filtered_covariance[-1]
        variance.append(np.trace(T @ P @ T.T))
    full, part, none = variance
    assert full < part < 0.5 * none
