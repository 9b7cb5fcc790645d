"""Transmission error of the virtual large robot, found with its laser tracker."""

import numpy as np
import pytest

from armside.kinematics import CATALOGUE
from armside.sim.cell import CELLS
from armside.sim.gears import GearsCfg, analyse
from armside.sim.measured import MotionRecording, Stream
from armside.sim.robot.cell_model import cell_model
from armside.sim.robot.effects import Effect, gear_orders, gear_phases, with_effects
from armside.sim.robot.flexibility import Flexibility, variant
from armside.sim.robot.virtual_robot import LOG_PERIOD, VirtualRobot

HOME = np.array([0.0, 0.0, 0.1, 0.3, -0.5, 0.2])
DURATION, EDGE = 90.0, 3.0
SLOW = (0.5, 3.0)
"""[Hz] Far below the first resonance, which amplifies what passes near it."""
SEEN = 10e-6
"""[m] Contribution of an axis at the tool that must be found."""
MOTOR_ORDER = 2
"""Place of the order of one period per motor turn in the robot's file."""
NOISE = 5e-6
"""[m] ESTIMATE of a tracker's."""


def reference():
    """Slow sums of sines of all motors (N, 6) [rad], at rest at both ends."""
    rng, time = np.random.default_rng(0), np.arange(0.0, DURATION, LOG_PERIOD)
    motion = np.zeros((len(time), 6))
    for joint in range(6):
        for _ in range(3):
            f, a = rng.uniform(0.02, 0.06), rng.uniform(0.13, 0.26)
            motion[:, joint] += a * np.sin(2.0 * np.pi * f * time + rng.uniform(0.0, 6.0))
    ramp = np.clip(time / EDGE, 0.0, 1.0)
    ramp = ramp**2 * (3.0 - 2.0 * ramp)
    return HOME + (ramp * ramp[::-1])[:, None] * motion


@pytest.fixture(scope="module")
def model():
    cell = CELLS["large"]
    nominal = cell_model(cell, variant(cell.xml, Flexibility.FULL))
    return with_effects(nominal, {Effect.GEAR_ERROR}, phi=HOME)


@pytest.fixture(scope="module")
def recording(model):
    run = VirtualRobot(model).load(reference()).run(rng=np.random.default_rng(1))
    truth = run.truth.every(2)
    noise = np.random.default_rng(2).normal(0.0, NOISE, truth.tool_position.shape)
    return MotionRecording(
        name="large",
        encoders=Stream(run.time, run.motor_angle),
        tracker=Stream(truth.time, truth.tool_position + noise),
        form="virtual",
    )


def test_each_axis_that_moves_the_tool_is_found(model, recording):
    """Amplitude within 20 %, phase at the middle of the travel within 0.2 rad."""
    done = analyse(CATALOGUE["large"], [recording], GearsCfg(sensor="tracker", band=SLOW))
    (aligned,), found = done.aligned, done.found
    assert found
    amplitude, order = (values[:, MOTOR_ORDER] for values in gear_orders(model))
    phase, middle = gear_phases(model)[:, MOTOR_ORDER], aligned.motion.phi.mean(axis=0)
    moved = np.linalg.norm(aligned.motion.point_jacobian(aligned.target), axis=1)
    contribution = amplitude * np.sqrt((moved**2).mean(axis=0))
    assert (contribution > SEEN).sum() == 3
    for joint in np.flatnonzero(contribution > SEEN):
        own = [term for term in found.terms if term.joint == joint + 1]
        term = min(own, key=lambda term: abs(term.order - order[joint]))
        assert abs(term.order - order[joint]) < 1.0
        assert abs(term.amplitude - amplitude[joint]) < 0.2 * amplitude[joint]
        off = term.phase - phase[joint] + (term.order - order[joint]) * middle[joint]
        assert abs((off + np.pi) % (2.0 * np.pi) - np.pi) < 0.2
