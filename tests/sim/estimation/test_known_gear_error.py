"""A gear error that is known: motors are asked for what makes outputs right, observers see it."""

from dataclasses import replace

import numpy as np
import pytest

from armside.kinematics.robot_file import GearTerm
from armside.sim.estimation.relative_path import relative_to_start
from armside.sim.laser.experiment import prepare
from armside.sim.laser.identification import arm_of
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.specification import Cut
from armside.sim.laser.tool_measure import ToolPath
from armside.sim.robot.drives import gear_error_of
from armside.sim.robot.effects import Effect
from armside.sim.robot.virtual_robot import LOG_PERIOD

from .rollout import observe

CUT = Cut(pose="p3", without=tuple(effect for effect in Effect if effect is not Effect.GEAR_ERROR))


@pytest.fixture(scope="module")
def plain():
    return prepare(CUT)


@pytest.fixture(scope="module")
def terms(plain):
    """The true gear error."""
    true = plain.loaded.model.gear_error
    joints, harmonics = true.order.shape
    parts = true.order, true.amplitude, true.phase
    return tuple(
        GearTerm(j + 1, *(float(part[j, h]) for part in parts))
        for j in range(joints)
        for h in range(harmonics)
    )


@pytest.fixture(scope="module")
def knowing(terms):
    return prepare(replace(CUT, gear_error=terms))


def test_outputs_of_the_gears_follow_what_motors_were_asked_for_before(plain, knowing, terms):
    asked = knowing.loaded.reference
    outputs = asked + gear_error_of(terms, 6)(asked)
    assert np.abs(asked - plain.loaded.reference).max() > 1e-5
    assert np.abs(outputs - plain.loaded.reference).max() < 2e-7, "second order in the error"
    learned = MotorAngles().prepare(knowing)(knowing.plant.run(np.zeros_like(asked)))
    np.testing.assert_array_equal(learned.reference, asked)


def test_an_observer_that_knows_the_gear_error_is_the_truth(plain, terms):
    run = plain.plant.run(np.zeros_like(plain.loaded.reference)).recording
    truth = run.truth.tool_position[:: round(LOG_PERIOD / float(run.truth.time[1]))]
    moved, arm = truth - truth[0], arm_of(plain)
    known = replace(arm, gear_error=gear_error_of(terms, 6))
    seen = (observe(one, run.motor_angle, LOG_PERIOD).tool_position[::8] for one in (arm, known))
    without, with_it = ((relative_to_start(path)[:, :3] - moved).std() for path in seen)
    assert with_it < 1.5e-6, "counts of the encoders, 2 to 4 urad, at 2.2 m"
    assert without > 3.0 * with_it


def test_the_assumed_arm_of_an_estimate_knows_it(plain, knowing):
    phi = plain.loaded.reference
    assert ToolPath().assumed(plain).gear_output(phi) is phi
    assert np.abs(ToolPath().assumed(knowing).gear_output(phi) - phi).max() > 1e-5
