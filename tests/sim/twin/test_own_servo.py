"""What a servo does beyond the type's, as the motors of recorded cuts show it."""

from dataclasses import replace

import numpy as np
import pytest

from armside.sim.robot.alien import AlienEffect
from armside.sim.robot.individual import Individual
from armside.sim.robot.spread import Alien, Drawn
from armside.sim.twin.commission import commission, plan, recorded
from armside.sim.twin.identification import Identification, parameters_of
from armside.sim.twin.own_servo import TAPS, OwnServo, own_servo, refined
from armside.sim.twin.sensitivities import Against
from armside.sim.twin.simulation import design_of, motor_path
from armside.sim.twin.twin import Twin, TwinError

DESIGN = design_of("large", None)
NOMINAL = Individual()


def cuts_of(individual, count=2):
    return [
        recorded(replace(cut, individual=individual), f"cut-{i + 1}", i)
        for i, cut in enumerate(plan(count))
    ]


def runs_of(design, cuts):
    return [design.run([NOMINAL], cut.reference, cut.correction)[0] for cut in cuts]


def left(design, cuts):
    """[rad], root mean square deviation of the motors from those of nominal robots."""
    runs = zip(cuts, runs_of(design, cuts), strict=True)
    return float(np.sqrt(np.mean([np.mean((c.motor_angle - motor_path(r)) ** 2) for c, r in runs])))


@pytest.fixture(scope="module")
def of_its_own():
    return cuts_of(Alien(8000, effect="own-servo"))


def test_a_servo_of_its_own_is_found_from_the_motors(of_its_own):
    found = own_servo(DESIGN, of_its_own, runs_of(DESIGN, of_its_own))
    assert found is not None
    assert left(DESIGN.besides(found), of_its_own) < 0.1 * left(DESIGN, of_its_own)


def test_what_a_found_servo_leaves_is_found_too(of_its_own):
    found = own_servo(DESIGN, of_its_own, runs_of(DESIGN, of_its_own))
    rough = OwnServo(0.8 * found.response, 0.5 * found.friction, 0.0)
    better = refined(rough, DESIGN, NOMINAL, of_its_own)
    before, after = (left(DESIGN.besides(servo), of_its_own) for servo in (rough, better))
    assert after < 0.5 * before


@pytest.mark.parametrize("number", [1001, 1003])
def test_friction_of_its_own_is_no_servo_of_its_own(number):
    cuts = cuts_of(Drawn(number))
    assert own_servo(DESIGN, cuts, runs_of(DESIGN, cuts)) is None


def test_set_points_reach_the_motors_with_their_late_parts():
    """By hand: a step of 1 rad at the third sample, half of it again 4 ms later."""
    step, response = 0.002, np.zeros(TAPS)
    response[1] = 0.5
    controls = np.zeros((8, 6, 3))
    controls[2:, 0, 0] = 1.0
    controls[:, 0, 2] = 7.0
    out = OwnServo(response, 0.0, 0.0).commands(controls, step)
    assert out[:, 0, 0].tolist() == [0.0, 0.0, 1.0, 1.0, 1.5, 1.5, 1.5, 1.5]
    assert np.array_equal(out[:, :, 1:], controls[:, :, 1:])
    assert np.array_equal(out[:, 1:], controls[:, 1:])


def test_a_twin_keeps_the_servo_that_it_was_commissioned_with(of_its_own, tmp_path):
    made = commission(of_its_own[:1], cfg=Identification(steps=1, linearised=(0,))).twin
    assert made.servo is not None
    assert made.design.model.own_drive is made.servo
    assert made.design_with(150.0).model.own_drive is made.servo
    made.save(tmp_path)
    kept = Twin.load(tmp_path).servo
    assert kept.content() == made.servo.content()
    replace(made, servo=OwnServo(np.full(TAPS, 3.0), 0.0, 0.0)).save(tmp_path)
    with pytest.raises(TwinError, match="servo must have 25 values"):
        Twin.load(tmp_path)


def test_the_sensitivity_to_hysteresis_says_what_more_of_it_does(of_its_own):
    """By the step of the difference quotient, to rounding: sticking and slipping is not linear."""
    design = DESIGN.besides(None, True)
    known = parameters_of(design)
    less = known.mean + 0.5 * np.eye(known.size)[known.at("hysteresis")][0]
    more = known.mean + 0.55 * np.eye(known.size)[known.at("hysteresis")][0]
    against = Against(design, known, of_its_own[0])
    before, columns = against.linearised(less)
    moved = before.tool - against.residuals(more).tool
    said = columns.tool @ (more - less)
    assert np.linalg.norm(moved) > 2.5e-5
    assert np.linalg.norm(moved - said) < 1e-6 * np.linalg.norm(moved)


def test_a_twin_with_hysteresis_is_kept(twin, tmp_path):
    design = DESIGN.besides(None, True)
    known = parameters_of(design)
    at = known.at("hysteresis").start
    prior = known.standard_deviation[at] ** 2
    covariance = np.insert(np.insert(twin.covariance, at, 0.0, axis=0), at, 0.0, axis=1)
    covariance[at, at] = 0.01 * prior
    theta = np.insert(twin.theta, at, 0.9)
    made = replace(twin, hysteresis=True, theta=theta, covariance=covariance)
    made.save(tmp_path)
    kept = Twin.load(tmp_path)
    assert kept.hysteresis
    assert kept.individual.alien == (AlienEffect("hysteresis", 0.9),)
    assert len({one.alien[0].size for one in kept.around}) > 1
    below = np.where(np.arange(len(theta)) == at, -1e-17, theta)
    assert known.individual(below, kept.gear_phase).alien == (AlienEffect("hysteresis", 0.0),)
