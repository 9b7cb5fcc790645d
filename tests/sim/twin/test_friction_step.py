"""Friction of a motion that was not made, by the law of the physics."""

import numpy as np
import pytest

from armside.assets import LARGE_ROBOT_XML
from armside.sim.robot.model import load_model
from armside.sim.twin.correction import friction_constants, lugre

STEP = 5e-4


@pytest.fixture(scope="module")
def constants():
    return friction_constants(load_model(LARGE_ROBOT_XML))


@pytest.mark.parametrize("speed", [0.5, -3.0, 60.0])
def test_friction_of_a_constant_speed_is_the_stribeck_curve(constants, speed):
    _, _, coulomb, static, stribeck = constants
    found = lugre(np.full((40_000, 6), speed), STEP, constants)[-1]
    curve = coulomb + (static - coulomb) * np.exp(-((speed / stribeck) ** 2))
    assert found == pytest.approx(np.sign(speed) * curve, rel=1e-6)


def test_friction_of_a_small_motion_is_a_spring_and_a_damper(constants):
    s0, s1, coulomb, *_ = constants
    distance = 1e-4 * coulomb / s0  # of the bristles, far below sliding
    time = STEP * np.arange(400)
    velocity = distance * np.pi * np.sin(10.0 * np.pi * time)[:, None] * 10.0
    found = lugre(velocity, STEP, constants)
    moved = np.vstack((np.zeros(6), np.cumsum(velocity, axis=0)[:-1])) * STEP
    assert found == pytest.approx(s0 * moved + s1 * velocity, abs=2e-3 * np.abs(found).max())


def test_friction_opposes_its_own_reversal(constants):
    velocity = np.random.default_rng(0).standard_normal((500, 6))
    forth, back = (lugre(sign * velocity, STEP, constants) for sign in (1.0, -1.0))
    assert back == pytest.approx(-forth)
