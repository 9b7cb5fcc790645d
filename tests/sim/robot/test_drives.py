"""Friction feedforward of the drives."""

from dataclasses import replace

import numpy as np
import pytest

from armside import assets
from armside.sim.robot.drives import friction_torque
from armside.sim.robot.model import load_model


@pytest.fixture(scope="module")
def drives():
    return load_model(assets.IRB1400_XML).drives


def test_the_feedforward_of_the_whole_friction_curve_is_scaled_by_its_gain(drives):
    v = np.array([[0.5] * 6])
    of_motor = v * drives.gear
    curve = (
        drives.coulomb_friction
        + (drives.static_friction - drives.coulomb_friction)
        * np.exp(-((of_motor / drives.stribeck_speed) ** 2))
        + drives.viscous_friction * of_motor
    )
    assert friction_torque(drives, v) == pytest.approx(0.7 * curve * drives.gear)


def test_the_feedforward_of_coulomb_friction_has_no_other_part(drives):
    plain = replace(drives, friction_curve=False)
    v = np.array([[0.5] * 6, [2.0] * 6])
    expected = np.tile(0.7 * drives.coulomb_friction * drives.gear, (2, 1))
    assert friction_torque(plain, v) == pytest.approx(expected)


def test_friction_feedforward_is_odd_in_velocity_and_zero_at_rest(drives):
    v = np.array([[0.01, 0.03, 0.1, 0.3, 1.0, 3.0]])
    assert friction_torque(drives, -v) == pytest.approx(-friction_torque(drives, v))
    assert not friction_torque(drives, np.zeros((1, 6))).any()
