"""The observed arm and its linear form beside the rollout."""

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.kinematics import LARGE_ROBOT, compile
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.observer import at_rest, dragged, fastest_mode, integrable, observe
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.robot.model import load_model

from .one_cut import spread


def test_observer_with_true_structure_and_exact_angles_is_the_truth(first):
    truth = first.recording.truth
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(structure=True))
    rate = np.gradient(truth.motor_angle, truth.time[1], axis=0)
    motion = dragged(arm, truth.motor_angle, rate)
    every = 8
    path = relative_to_start(motion.tool_position[::every])
    true = relative_to_start(truth.tool_position[::every])
    assert spread(path, true) <= 0.5e-6


def test_linearised_arm_is_the_rollout_linearised():
    """Same springs; a motion of 0.1 mrad."""
    arm = nominal_arm(load_model(LARGE_ROBOT_XML))
    phi0 = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
    t = np.arange(2000) * arm.mj.opt.timestep
    phi = phi0 + 1e-4 * np.sin(2 * np.pi * 3.0 * t)[:, None] ** 3
    motion = dragged(arm, phi, np.gradient(phi, t[1], axis=0))
    from armside.ilc.estimation.process import first_order_hold, simulate

    A, B = linearised(arm, phi0).dynamics()
    inputs = np.hstack((phi - phi0, np.gradient(phi, t[1], axis=0)))
    x = simulate(*first_order_hold(A, B, t[1]), inputs)
    assert np.abs(motion.q - motion.q[0] - x[:, :6]).max() < 0.02 * np.abs(x[:, :6]).max()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"stiffness": 0.0}, "stiffness"),
        ({"damping": -1.0}, "damping"),
        ({"link_mass": np.nan}, "link_mass"),
    ],
)
def test_a_nominal_arm_says_what_is_out_of_range(options, said):
    with pytest.raises(ValueError, match=said):
        NominalCfg(**options)


LIGHT = NominalCfg(payload=-39.5, stiffness=(1.0, 1.0, 1.0, 3.0, 3.0, 3.0))
"""The tool of the findings, 0.5 kg, on wrist springs as stiff as an identification made them."""
PERIOD = 0.004
REST = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
STABLE = 1.0 / np.pi  # mode [Hz] times step [s] up to which semi-implicit Euler is stable


def wave(n=300):
    """Motor angles (n, 6) [rad], at rest at the beginning."""
    t = np.arange(n) * PERIOD
    swing = 2e-3 * np.sin(2 * np.pi * 1.5 * np.maximum(t - 0.2, 0.0)) ** 3
    return REST + swing[:, None]


def test_observer_of_a_light_stiff_tool_stays_with_its_motors():
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), LIGHT)
    fastest = fastest_mode(arm, at_rest(arm, REST))
    assert fastest * arm.mj.opt.timestep > STABLE  # the robot's own step would blow up
    phi = wave()
    motion = observe(arm, phi, PERIOD)
    every = round(PERIOD / (motion.time[1] - motion.time[0]))
    path = relative_to_start(motion.tool_position[::every])[:, :3]
    rigid = relative_to_start(compile(LARGE_ROBOT).pose(phi)[:, :3, 3])[:, :3]
    assert len(path) == len(phi)
    assert np.abs(path - rigid).max() < 0.2 * np.abs(rigid).max()


def test_fastest_mode_is_the_last_of_the_linearised_arm():
    arm = nominal_arm(load_model(LARGE_ROBOT_XML))
    found = fastest_mode(arm, at_rest(arm, REST))
    assert found == pytest.approx(linearised(arm, REST).locked_modes()[-1], rel=1e-3)


def test_an_ordinary_arm_keeps_the_step_of_its_robot():
    arm = nominal_arm(load_model(LARGE_ROBOT_XML))
    assert integrable(arm, at_rest(arm, REST)) is arm


def test_an_arm_without_a_tool_is_possible():
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(payload=-40.0))
    assert arm.mj.body("tool").mass[0] == 0.0


def test_a_tool_lighter_than_nothing_is_refused():
    with pytest.raises(ValueError, match=r"payload of the assumed arm must be >= 0 kg: -41 kg"):
        nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(payload=-41.0))
