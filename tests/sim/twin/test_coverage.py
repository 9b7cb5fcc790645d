"""Coverage of the standard deviations of a twin's parameters, nominal 95 %.

Those of the linearised model hold the truth of records that such a model made, with noise that
lasts as long as identification assumes. Those that `armside commission` prints hold the truth of
robots, whose individuals here are none that anything was chosen on.
"""

import os
from dataclasses import dataclass, replace

import numpy as np
import pytest

from armside.arrays import Array
from armside.ilc.filters import ZeroPhaseButterworth
from armside.sim.instruments.imu import ImuCfg
from armside.sim.robot.mjcf import N_AXES
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import SENSORS, commission, plan, recorded
from armside.sim.twin.identification import CORRELATION, TORQUE_NOISE, Solving, compared
from armside.sim.twin.imu_sensor import CFG as UNIT
from armside.sim.twin.imu_sensor import CUTOFF, IMU
from armside.sim.twin.prediction import is_identified, standard_deviation
from armside.sim.twin.sensitivities import Columns, Residuals
from armside.sim.twin.tool_sensor import TRACKER, ToolSensor

from .conftest import INDIVIDUAL

WHOLE = bool(os.environ.get("ARMSIDE_CI"))
DRAWS, STEPS = 8 if WHOLE else 4, 3
LASTS = round(CORRELATION**2)
"""Samples that share one draw of the noise: as many as the scale of residuals assumes."""


@dataclass(frozen=True, eq=False)
class LinearCut:
    """A cut whose residuals are linear in theta, in place of simulations."""

    sensor: ToolSensor
    columns: Columns
    truth: Array
    noise: Residuals

    def residuals(self, theta: Array) -> Residuals:
        left = self.truth - theta
        torque = self.columns.torque @ left + self.noise.torque
        return Residuals(torque, self.columns.tool @ left + self.noise.tool, self.noise.moving)


def lasting(rng, n, columns):
    return np.repeat(rng.standard_normal((n // LASTS + 1, columns)), LASTS, axis=0)[:n]


def seen(sensor, rng, columns):
    """Columns and noise; of an IMU slow columns of its size, in low-passed white noise."""
    if sensor is TRACKER:
        return columns, TRACKER.noise / CORRELATION * lasting(rng, len(columns), 3)
    Q = ZeroPhaseButterworth(CUTOFF, 1.0 / UNIT.rate)
    slow = Q(columns.reshape(len(columns), -1)).reshape(columns.shape)
    return slow / IMU.displacement, Q(rng.standard_normal((len(columns), 3)))


@pytest.mark.parametrize("kind", ["tracker", "imu"])
def test_standard_deviations_hold_the_truth_of_a_linear_cut_at_their_rate(around, kind):
    against, _, before, columns = around
    parameters, rng, inside = against.parameters, np.random.default_rng(0), []
    sensor = SENSORS[kind]
    least = TORQUE_NOISE * against.design.model.drives.torque_limit
    for _ in range(DRAWS):
        drawn = parameters.standard_deviation * rng.standard_normal(parameters.size)
        truth = np.clip(parameters.mean + drawn, parameters.lower, parameters.upper)
        tool, noise = seen(sensor, rng, columns.tool)
        torque = least / CORRELATION * lasting(rng, len(columns.torque), N_AXES)
        noises = Residuals(torque, noise, before.moving)
        cut = LinearCut(sensor, Columns(columns.torque, tool), truth, noises)
        theta, sd = solved(cut, parameters, least)
        inside.append(np.abs(theta - truth) < 1.96 * sd)
    assert 0.90 <= np.mean(inside) <= 0.99


def solved(cut, parameters, torque_noise):
    """Parameters and their standard deviations, by the solver of identification."""
    sensor, theta = cut.sensor, parameters.mean
    scales = np.append(torque_noise, sensor.noise)
    correlation = np.append(np.full(N_AXES, CORRELATION), sensor.correlation)
    for _ in range(STEPS):
        groups = compared(cut, theta, cut.columns).groups
        solving = Solving(parameters, theta, scales, correlation)
        change, covariance = solving.solve(groups)
        theta = theta + change
    return theta, np.sqrt(np.diag(covariance))


LOGARITHMS = ("static_excess", "stribeck_speed", "viscous", "bristle_stiffness", "lost_motion")


def truth_of(robot, twin):
    """Individual as parameters (m,); NaN where a twin's parameter has no counterpart in it."""
    parameters, theta = twin.parameters, np.full(twin.parameters.size, np.nan)
    one = robot.of(twin.design.nominal).of(N_AXES)
    phase = one.gear_error_phase + twin.gear_phase + one.ripple_phase[:, None]
    known = {name: np.log(getattr(one, name)) for name in LOGARITHMS} | {
        "friction_constant": np.log(one.friction * one.friction_constant),
        "friction_load": np.log(one.friction * one.friction_load),
        "ripple": waves(one.ripple, one.ripple_phase),
        "mass": one.mass - 1.0,
        "gear_stiffness": 1.0 / one.gear_stiffness - 1.0,
        "structure_stiffness": 1.0 / np.asarray(one.structure_stiffness) - 1.0,
        "gear_error": waves(one.gear_error, phase),
        "position": one.position,
        "orientation": one.orientation,
    }
    for name, value in known.items():
        theta[parameters.at(name)] = np.ravel(value)
    return theta


def waves(amplitude, phase):
    """(..., 2), amplitudes of cosine and sine."""
    return amplitude[..., None] * np.stack((np.cos(phase), np.sin(phase)), axis=-1)


def coverage(robot, twin, sd):
    """Of the identified parameters, and of all."""
    truth = truth_of(robot, twin)
    known, there = is_identified(twin.parameters, twin.covariance), np.isfinite(truth)
    inside = np.abs(twin.theta - truth) < 1.96 * sd
    return inside[known & there].mean(), inside[there].mean()


def test_printed_standard_deviations_hold_the_truth_of_a_robot_at_their_rate(twin):
    """Those of the linearised model would hold it less often."""
    printed = standard_deviation(twin.parameters, twin.covariance)
    assert all(0.90 <= each <= 0.99 for each in coverage(INDIVIDUAL, twin, printed))
    assert coverage(INDIVIDUAL, twin, np.sqrt(np.diag(twin.covariance)))[0] < 0.90


@pytest.mark.skipif(not WHOLE, reason="minutes: robots from more cuts")
@pytest.mark.parametrize("measure", ["tracker", "imu"])
def test_printed_standard_deviations_hold_the_truth_of_other_robots(measure):
    found = []
    for robot in (Drawn(2005), Drawn(2006)):
        imu = ImuCfg() if measure == "imu" else None
        cuts = [
            recorded(replace(cut, individual=robot, imu=imu), f"cut-{i + 1}", i)
            for i, cut in enumerate(plan(4))
        ]
        twin = commission(cuts, measure=measure).twin
        printed = standard_deviation(twin.parameters, twin.covariance)
        found.append(coverage(robot, twin, printed))
    assert ((np.mean(found, axis=0) >= 0.90) & (np.mean(found, axis=0) <= 0.99)).all()
