"""Friction of servo drives, identified from their runs, in learning without design variables."""

from dataclasses import dataclass

import numpy as np
import pytest

from armside.ilc import ZeroPhaseButterworth
from armside.ilc.identification.friction import FRACTIONS, Friction, friction, stops
from armside.ilc.laws.knob_free import KnobFree

from .signals import error_norms

T_S, SUBSTEPS = 0.004, 8
t = np.arange(300) * T_S
DIP = 0.2 * np.exp(-(((t - 0.5) / 0.12) ** 2))[:, None] * [[1.0, 0.5]]
"""Two motors that turn back, by 0.2 and 0.1 rad."""
Q = ZeroPhaseButterworth(25.0, T_S)


@dataclass
class Servo:
    """Proportional-derivative servo at 40 rad/s, damping 0.7, of an inertia with friction."""

    level: float = 0.06
    """Friction over k_p [rad]."""
    width: float = 0.004
    """Of the stop [rad]."""

    def run(self, correction):
        omega, step = 40.0, T_S / SUBSTEPS
        y, speed, held, found = np.zeros(2), np.zeros(2), np.zeros(2), np.empty_like(correction)
        for i, wanted in enumerate(DIP + correction):
            found[i] = y
            for _ in range(SUBSTEPS):
                force = wanted - y - self.level * held - 1.4 / omega * speed
                speed = speed + step * omega**2 * force
                y = y + step * speed
                held = np.clip(held + step * speed / self.width, -1.0, 1.0)
        return found


def held_by(model: Friction) -> np.ndarray:
    return model.size.sum(axis=1)


def test_run_0_says_at_which_level_a_motor_slips():
    servo = Servo()
    zero = np.zeros_like(DIP)
    found = friction(DIP, [(zero, DIP - servo.run(zero))])
    assert held_by(found)[0] == pytest.approx(servo.level, rel=0.15)


def test_friction_of_its_own_form_is_found_exactly_with_its_delay():
    sizes = np.array([[0.0, 0.05, 0.0], [0.01, 0.0, 0.02]])
    none = np.zeros(2)
    truth = Friction(np.ptp(DIP, axis=0)[:, None] * np.array(FRACTIONS), sizes, none, none, 3)
    found = friction(DIP, [(truth.as_correction(DIP), 0.0 * DIP)])
    assert found.delay == 3
    np.testing.assert_allclose(found.size, sizes, atol=1e-6)  # the lead cuts three samples off


def test_the_integral_action_of_a_servo_is_found_with_its_friction():
    """An integrating servo forgets a constant friction, so less correction balances it later."""
    sizes, kappa = np.array([[0.0, 0.05, 0.0], [0.01, 0.0, 0.02]]), np.array([0.05, 0.02])
    widths = np.ptp(DIP, axis=0)[:, None] * np.array(FRACTIONS)
    truth = Friction(widths, sizes, kappa, np.zeros(2), 3)
    found = friction(DIP, [(truth.as_correction(DIP), 0.0 * DIP)])
    np.testing.assert_allclose(found.kappa, kappa, rtol=0.05)  # sums against trapezoids: kappa / 2
    np.testing.assert_allclose(found.size, sizes, rtol=0.05, atol=1e-3)


def test_a_servo_without_friction_has_none():
    zero = np.zeros_like(DIP)
    found = friction(DIP, [(zero, DIP - Servo(level=0.0).run(zero))])
    np.testing.assert_allclose(held_by(found), 0.0, atol=0.005)


def test_friction_as_a_correction_comes_before_the_motion_by_its_delay():
    now = Friction(np.full((2, 1), 0.01), np.full((2, 1), 0.05), np.zeros(2), np.zeros(2), 0)
    early = Friction(now.widths, now.size, now.kappa, now.tau, 3)
    np.testing.assert_allclose(now.as_correction(DIP), 0.05 * stops(DIP, [0.01])[:, :, 0])
    np.testing.assert_array_equal(early.as_correction(DIP)[:-3], now.as_correction(DIP)[3:])


def test_motors_that_stick_are_learned_in_fewer_runs_where_the_reference_is_known():
    without, known = (error_norms(Servo(), KnobFree(Q=Q, reference=r), DIP, 4) for r in (None, DIP))
    assert known.max() == known[0]
    assert np.argmax(known < 0.1 * known[0]) in range(1, 5)
    assert known[3] < 0.5 * without[3]


def test_a_motor_that_does_not_move_has_no_friction():
    still = DIP * [[1.0, 0.0]]
    found = friction(still, [(0 * still, 0.1 * still)])
    assert held_by(found)[1] == 0.0
    assert np.isfinite(found.as_correction(still)).all()


@pytest.mark.parametrize("runs", [[], [(DIP, DIP[:-1])]])
def test_runs_of_another_length_are_refused(runs):
    with pytest.raises(ValueError, match=r"records of shape \(300, 2\), one or more"):
        friction(DIP, runs)


@pytest.mark.parametrize("hostile", [np.full_like(DIP, np.nan), DIP.astype(complex), DIP[:, 0]])
def test_a_record_that_is_none_is_refused(hostile):
    for run in ((hostile, DIP), (DIP, hostile)):
        with pytest.raises(ValueError, match=r"must be|must have shape"):
            friction(DIP, [run])


def test_a_reference_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"reference has shape \(300, 2\), the record has"):
        KnobFree(Q=Q, reference=DIP).check(200, 2)
