"""Frequency responses from multisines: exact without noise, and as uncertain as they say."""

import numpy as np
import pytest

from armside.ilc.identification.frequency_response import (
    PeriodicRecord,
    frequency_response,
    lines_between,
    orthogonal_multisines,
)
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

STEP, PERIOD = 0.004, 100
LINES = lines_between(2.5, 60.0, PERIOD, STEP)


def lag(b, a):
    return System(np.array(b, dtype=float), np.array(a, dtype=float), STEP)


SERVO = SystemMatrix(
    (
        (lag([0, 0, 0.3], [1, -0.7]), lag([0, 0.05], [1, -0.2, 0.3])),
        (lag([0.02, 0.1], [1, -0.5]), lag([0, 0.4], [1, -0.6])),
    )
)
"""Two coupled motors; (p, n) = (2, 2)."""


def experiments(rng, periods=6, noise=0.0, output=lambda y: y):
    """Records of one realisation; noise with a spectrum of its own."""
    colour = lag([1.0], [1, -0.8])
    for u in orthogonal_multisines(PERIOD, LINES, 2, rng, rms=[1.0, 2.0]):
        u = np.tile(u, (periods, 1))
        e = noise * colour.simulate(rng.standard_normal((u.shape[0], 2)))
        yield PeriodicRecord(u, output(SERVO.simulate(u)) + e)


def measured(rng, realisations=1, omitted=2, **given):
    each = [list(experiments(rng, **given)) for _ in range(realisations)]
    return frequency_response(each, PERIOD, LINES, omitted=omitted)


def test_multisines_are_orthogonal_and_have_power_at_their_lines_alone():
    u = orthogonal_multisines(PERIOD, LINES, 3, np.random.default_rng(0), rms=[1.0, 2.0, 3.0])
    np.testing.assert_allclose(np.sqrt(np.square(u).mean(axis=1)), [[1.0, 2.0, 3.0]] * 3)
    U = np.fft.rfft(u, axis=1)
    np.testing.assert_allclose(np.delete(U, LINES, axis=1), 0.0, atol=1e-11)
    for line in LINES:
        gram = U[:, line].T @ U[:, line].conj()  # inputs by inputs
        np.testing.assert_allclose(gram, np.diag(np.diag(gram)), atol=1e-9 * abs(gram).max())


def test_the_response_of_coupled_motors_is_exact_without_noise():
    found = measured(np.random.default_rng(1), omitted=4)
    np.testing.assert_allclose(found.omega, 2 * np.pi * np.array(LINES) / PERIOD)
    np.testing.assert_allclose(found.response, SERVO.response(found.omega), atol=1e-12)


def coverage(rng, repetitions=25, **given):
    inside = []
    for _ in range(repetitions):
        found = measured(rng, **given)
        error = np.abs(found.response - SERVO.response(found.omega))
        inside.append(error < found.radius())
    return np.mean(inside)


@pytest.mark.parametrize("realisations", [1, 4])
def test_discs_of_95_percent_hold_the_true_response_at_their_rate(realisations):
    """25 times 23 lines and 4 entries: the rate scatters by 0.5 %."""
    rate = coverage(np.random.default_rng(2), realisations=realisations, noise=0.2)
    assert 0.93 <= rate <= 0.97


def test_a_system_that_is_not_linear_is_said_and_its_discs_hold_its_mean_response():
    """y + 0.3 y^3: the noise alone says less than a tenth of what realisations differ by."""
    rng, count = np.random.default_rng(3), 20
    given = {"realisations": 5, "noise": 0.01, "output": lambda y: y + 0.3 * y**3}
    found = [measured(rng, **given) for _ in range(count)]
    mean = np.mean([one.response for one in found], axis=0)
    error = np.abs([one.response - mean for one in found]) / np.sqrt(1.0 - 1.0 / count)
    assert 0.92 <= np.mean(error < [one.radius() for one in found]) <= 0.98
    assert all("not linear" in one.warnings[0] for one in found)
    assert np.median(error / np.sqrt([one.noise_variance for one in found])) > 5.0


def test_a_start_that_has_not_died_out_is_said():
    rng = np.random.default_rng(4)
    assert any("omit more" in text for text in measured(rng, noise=0.01, omitted=0).warnings)
    quiet = [measured(rng, realisations=3, noise=0.2).warnings for _ in range(30)]
    assert not any(quiet)


@pytest.mark.parametrize("exact", [0.0, 1.0, 1e6], ids=["dead", "without noise", "large"])
def test_an_output_without_noise_hides_nothing_of_the_others(exact):
    """Output 1 is `exact` times what the servo does; output 2 has noise, and a fault."""

    def seen(fault, periods=6):
        rng, each = np.random.default_rng(6), []
        for _ in range(3):
            records = experiments(rng, periods, output=lambda y: y + fault * y**3)
            noise = [0.0, 0.01] * rng.standard_normal((PERIOD * periods, 2))
            each.append([PeriodicRecord(u, y * [exact, 1.0] + noise) for u, y in records])
        return each

    late = frequency_response(seen(0.0), PERIOD, LINES, omitted=0)
    assert any("omit more" in text for text in late.warnings)
    bent = frequency_response(seen(0.3), PERIOD, LINES, omitted=2)
    assert any("not linear" in text for text in bent.warnings)
    assert frequency_response(seen(0.0), PERIOD, LINES, omitted=4).warnings == ()
    assert frequency_response(seen(0.0, 9), PERIOD, LINES, omitted=5).warnings == ()


def test_a_simulated_plant_is_linear_if_it_is():
    rng = np.random.default_rng(7)
    assert measured(rng, realisations=3, omitted=2, periods=9).warnings == ()
    bent = measured(rng, realisations=3, omitted=2, output=lambda y: y + 1e-6 * y**3)
    assert any("not linear" in text for text in bent.warnings)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"records": 1}, "2 inputs need 2 experiments"),
        ({"samples": -1}, "whole periods of 100 samples, got 599 and 599"),
        ({"samples": -400}, "two periods must remain, got 0"),
        ({"same": True}, "do not excite all inputs"),
    ],
)
def test_experiments_that_say_too_little_are_refused(change, message):
    records = list(experiments(np.random.default_rng(5)))[: change.get("records", 2)]
    end = change.get("samples")
    records = [PeriodicRecord(np.array(u)[:end], np.array(y)[:end]) for u, y in records]
    if "same" in change:
        records = records[:1] * 2
    with pytest.raises(ValueError, match=message):
        frequency_response([records], PERIOD, LINES, omitted=2)


@pytest.mark.parametrize("lines", [[0, 1], [50], [1, 1], [1.5], []])
def test_lines_that_no_period_has_are_refused(lines):
    with pytest.raises(ValueError, match="from 1 to below 50"):
        orthogonal_multisines(PERIOD, lines, 1, np.random.default_rng(0))
    records = [list(experiments(np.random.default_rng(0)))]
    for each in (lines, [-3, 2], [200]):
        with pytest.raises(ValueError, match="from 1 to below 50"):
            frequency_response(records, PERIOD, each)
    with pytest.raises(ValueError, match="got 0 to 60 Hz"):
        lines_between(0.0, 60.0, PERIOD, STEP)
