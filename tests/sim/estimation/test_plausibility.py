"""Estimates that the encoders contradict, and the step of the observer that makes none of them."""

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.observer import at_rest, fastest_mode, integrable, observe
from armside.sim.estimation.plausibility import EstimateError, check_plausible, rigid_position
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.robot.model import load_model

PERIOD = 0.004
REST = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
STABLE = 1.0 / np.pi  # mode [Hz] times step [s] up to which semi-implicit Euler is stable
LIGHT = NominalCfg(payload=-39.5, stiffness=(1.0, 1.0, 1.0, 3.0, 3.0, 3.0))
"""The tool of the findings, 0.5 kg, on wrist springs as stiff as an identification made them."""


@pytest.fixture(scope="module")
def robot():
    return load_model(LARGE_ROBOT_XML)


def wave(n=300):
    """Motor angles (n, 6) [rad], at rest at the beginning."""
    t = np.arange(n) * PERIOD
    swing = 2e-3 * np.sin(2 * np.pi * 1.5 * np.maximum(t - 0.2, 0.0)) ** 3
    return REST + swing[:, None]


def test_observer_of_a_light_stiff_tool_stays_with_its_motors(robot):
    arm = nominal_arm(robot, LIGHT)
    fastest = fastest_mode(arm, at_rest(arm, REST))
    assert fastest * arm.mj.opt.timestep > STABLE  # the robot's own step would blow up
    phi = wave()
    motion = observe(arm, phi, PERIOD)
    every = round(PERIOD / (motion.time[1] - motion.time[0]))
    path = relative_to_start(motion.tool_position[::every])[:, :3]
    rigid = relative_to_start(rigid_position(arm, phi))[:, :3]
    assert len(path) == len(phi)
    assert np.abs(path - rigid).max() < 0.2 * np.abs(rigid).max()


def test_fastest_mode_is_the_last_of_the_linearised_arm(robot):
    arm = nominal_arm(robot)
    found = fastest_mode(arm, at_rest(arm, REST))
    assert found == pytest.approx(linearised(arm, REST).locked_modes()[-1], rel=1e-3)


def test_an_ordinary_arm_keeps_the_step_of_its_robot(robot):
    arm = nominal_arm(robot)
    assert integrable(arm, at_rest(arm, REST)) is arm


@pytest.mark.parametrize("off", [3e-3, np.nan, np.inf])
def test_an_estimate_that_leaves_its_motors_is_refused(robot, off):
    arm, phi = nominal_arm(robot), wave()
    linear = linearised(arm, REST)
    path = relative_to_start(rigid_position(arm, phi))[:, :3]
    check_plausible(path, arm, linear, phi, PERIOD)
    path[200, 1] += off
    with pytest.raises(EstimateError, match=r"at 0\.80 s"):
        check_plausible(path, arm, linear, phi, PERIOD)


def test_the_plausible_deflection_is_that_of_the_observer(robot):
    """Below resonance the observer deflects as the springs do: the bound has the right scale."""
    arm, phi = nominal_arm(robot), wave()
    motion = observe(arm, phi, PERIOD)
    path = relative_to_start(motion.tool_position[::8])[:, :3]
    check_plausible(path, arm, linearised(arm, REST), phi, PERIOD)
    rigid = relative_to_start(rigid_position(arm, phi))[:, :3]
    doubled = rigid + 20.0 * (path - rigid)
    with pytest.raises(EstimateError):
        check_plausible(doubled, arm, linearised(arm, REST), phi, PERIOD)


def test_an_arm_without_a_tool_is_possible(robot):
    arm = nominal_arm(robot, NominalCfg(payload=-40.0))
    assert arm.mj.body("tool").mass[0] == 0.0


def test_a_tool_lighter_than_nothing_is_refused(robot):
    with pytest.raises(ValueError, match=r"payload of the assumed arm must be >= 0 kg: -41 kg"):
        nominal_arm(robot, NominalCfg(payload=-41.0))
