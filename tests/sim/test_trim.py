"""Calibration: what a trim sets, in a model and in the text of its file."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from armside import assets
from armside.scripts.commands.calibrate import START, mutate
from armside.sim.calibration.parameters import apply, numbers, rewrite
from armside.sim.calibration.targets import Finding, learning_findings
from armside.sim.robot.effects import available
from armside.sim.robot.model import load_model


def _same(a, b):
    return (
        np.allclose(a.jnt_stiffness, b.jnt_stiffness, rtol=1e-7)
        and np.allclose(a.dof_damping, b.dof_damping, rtol=1e-7)
        and np.allclose(a.actuator_gainprm, b.actuator_gainprm, rtol=1e-7)
        and np.allclose(a.actuator_dynprm, b.actuator_dynprm, rtol=1e-7)
        and np.allclose(a.numeric_data, b.numeric_data, rtol=1e-7)
    )


def test_file_and_model_get_the_same_numbers():
    trim = replace(START, gear_soft=0.2, lost_motion=0.5, friction=(1.0, 1.1, 1.2, 1.3, 1.4, 1.5))
    text = assets.LARGE_ROBOT_XML.read_text()
    written = mujoco.MjModel.from_xml_string(rewrite(text, trim))
    applied = mujoco.MjModel.from_xml_string(text)
    assert not _same(written, applied)
    apply(applied, trim)
    assert _same(written, applied)


def test_rewriting_twice_changes_nothing():
    text = rewrite(assets.LARGE_ROBOT_XML.read_text(), START)
    assert rewrite(text, START) == text


def test_a_file_without_the_named_element_is_refused():
    text = assets.LARGE_ROBOT_XML.read_text().replace('"gear_temperature"', '"oven"')
    with pytest.raises(ValueError, match="gear_temperature"):
        rewrite(text, START)


def test_servo_gains_are_those_of_a_second_order_system():
    found = numbers(START)
    inertia = 220.0**2 * 5.0e-3 + 700.0
    w0 = 2 * np.pi * START.servo_frequency[0]
    assert found.controllers[0] * 220.0**2 == pytest.approx(
        [inertia * w0**2, 2 * START.servo_damping * inertia * w0]
    )


def test_a_trim_that_makes_no_sense_is_refused():
    with pytest.raises(ValueError, match="servo_damping"):
        replace(START, servo_damping=float("nan"))


def test_mutation_is_the_same_for_the_same_seed_and_keeps_three_digits():
    one, two = (mutate(START, np.random.default_rng(5)) for _ in range(2))
    assert one == two != START
    for value in (one.servo_damping, *one.servo_frequency, *one.friction):
        assert value == pytest.approx(float(f"{value:.3g}"), rel=1e-12)


def test_a_finding_says_how_far_it_is_outside():
    assert Finding("x", 1.0, 0.5, 2.0).outside == 0.0
    assert Finding("x", 3.0, high=2.0, margin=0.0).outside == pytest.approx(0.5)
    assert Finding("x", 1.0, low=1.0).outside == pytest.approx(0.05)
    assert Finding("x", 1.0, low=1.0).holds


def test_the_committed_robot_meets_its_learning_targets():
    """All targets: armside calibrate --generations 0."""
    model = load_model(assets.LARGE_ROBOT_XML)
    missed = [f for f in learning_findings(model, available(model)) if not f.holds]
    assert not missed
