"""Inverse kinematics by damped Gauss-Newton steps, for robots without a closed form."""

from dataclasses import replace

import numpy as np
import pytest

from armside.kinematics import LARGE_ROBOT, NotConvergedError, Robot, compile, inverse_numeric


def test_numeric_fallback_solves_a_wrist_that_is_not_spherical():
    links = list(LARGE_ROBOT.links)
    links[3] = replace(links[3], a=0.05)
    robot = Robot(links, offset=LARGE_ROBOT.offset)
    functions = compile(robot)
    phi = np.array([0.2, -0.3, 0.2, 0.3, 0.8, -0.4])
    found = inverse_numeric(robot, functions.pose(phi), start=phi + 0.3)
    np.testing.assert_allclose(functions.pose(found), functions.pose(phi), rtol=0, atol=1e-9)


def test_numeric_fallback_says_what_remains_when_it_fails():
    T = np.eye(4)
    T[0, 3] = 10.0
    with pytest.raises(NotConvergedError, match="mm and"):
        inverse_numeric(LARGE_ROBOT, T, start=np.full(6, 0.1))
    with pytest.raises(ValueError, match="finite"):
        inverse_numeric(LARGE_ROBOT, T * np.nan, start=np.zeros(6))
