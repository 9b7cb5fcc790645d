"""Known transmission error from the terms of a file."""

import numpy as np
import pytest

from armside.kinematics.robot_file import GearTerm
from armside.sim.robot.gear_terms import gear_error_of

TERMS = (
    GearTerm(1, 100.0, 2e-5, 0.3),
    GearTerm(3, 120.0, 1e-5, 2.0),
    GearTerm(1, 200.0, 5e-6, 1.0),
)


def test_error_of_a_joint_is_the_sum_of_its_terms():
    phi = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3))
    expected = np.zeros_like(phi)
    for term in TERMS:
        angle = term.order * phi[:, term.joint - 1] + term.phase
        expected[:, term.joint - 1] += term.amplitude * np.sin(angle)
    np.testing.assert_allclose(gear_error_of(TERMS, 3)(phi), expected, atol=1e-16)


def test_a_robot_without_that_joint_is_refused():
    with pytest.raises(ValueError, match="gear error of joint 3: the robot has 2 joints"):
        gear_error_of(TERMS, 2)
