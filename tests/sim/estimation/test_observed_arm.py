"""The observed arm and its linear form beside the rollout."""

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.ilc.estimation.process import first_order_hold, simulate
from armside.sim.estimation.linearised_arm import linearised
from armside.sim.estimation.nominal import NominalCfg, nominal_arm
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.robot.model import load_model

from .one_cut import spread
from .rollout import dragged


def test_observer_with_true_structure_and_exact_angles_is_the_truth(first):
    truth = first.recording.truth
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(structure=True))
    rate = np.gradient(truth.motor_angle, truth.time[1], axis=0)
    motion = dragged(arm, truth.motor_angle, rate)
    path, true = (relative_to_start(one.tool_position[::8]) for one in (motion, truth))
    assert spread(path, true) <= 0.5e-6


def test_linearised_arm_is_the_rollout_linearised():
    """Same springs; a motion of 0.1 mrad."""
    arm = nominal_arm(load_model(LARGE_ROBOT_XML))
    phi0 = np.array([0.1, 0.2, 0.3, 0.1, 0.5, 0.1])
    t = np.arange(2000) * arm.mj.opt.timestep
    phi = phi0 + 1e-4 * np.sin(2 * np.pi * 3.0 * t)[:, None] ** 3
    rate = np.gradient(phi, t[1], axis=0)
    motion = dragged(arm, phi, rate)
    A, B = linearised(arm, phi0).dynamics()
    x = simulate(*first_order_hold(A, B, t[1]), np.hstack((phi - phi0, rate)))
    assert np.abs(motion.q - motion.q[0] - x[:, :6]).max() < 0.02 * np.abs(x[:, :6]).max()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"stiffness": 0.0}, "stiffness"),
        ({"damping": -1.0}, "damping"),
        ({"stiffness": (1.0, np.nan)}, "stiffness"),
        ({"payload": -41.0}, "payload of the assumed arm must be >= 0 kg: -41 kg"),
    ],
)
def test_a_nominal_arm_says_what_is_out_of_range(options, said):
    with pytest.raises(ValueError, match=said):
        nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(**options))


def test_an_arm_without_a_tool_is_possible():
    arm = nominal_arm(load_model(LARGE_ROBOT_XML), NominalCfg(payload=-40.0))
    assert arm.mj.body("tool").mass[0] == 0.0
