"""The bench of Chen and Tomizuka: its printed modes and peaks, its laws and estimators."""

import numpy as np
import pytest

from armside.ilc.bench_study import AMPLITUDE, CHIRP_AMPLITUDE
from armside.ilc.dual_stage import DualStage, by_frequency, laplace, rms_and_peak
from armside.ilc.estimation.elastic_joint import chirp, dkf, kkf, measured
from armside.ilc.models.elastic_bench import (
    LOAD_COUNT,
    MOTOR_COUNT,
    STEP,
    Individual,
    TwoMass,
    reference,
    run,
)

EXACT = Individual(amplitude=0.0)
DEVELOPED = Individual.drawn(0, AMPLITUDE)


def test_its_modes_are_those_that_follow_from_the_printed_numbers():
    """10.75 Hz with the motor locked, 18.6 Hz free: zero and pole of the motor's response."""
    f = np.linspace(5.0, 30.0, 25_001)
    stiff = np.abs(TwoMass().torque_over_motor(2j * np.pi * f))
    assert f[stiff.argmax()] == pytest.approx(10.75, abs=0.1)
    assert f[1000 + stiff[1000:].argmin()] == pytest.approx(18.6, abs=0.2)


def test_its_reference_has_the_printed_way_speed_and_peaks():
    time, q = reference()
    speed, acceleration = np.gradient(q, STEP), np.gradient(np.gradient(q, STEP), STEP)
    assert (q.max(), abs(q[-1])) == pytest.approx((0.8, 0.0), abs=1e-9)
    assert np.abs(speed).max() == pytest.approx(0.5, abs=1e-6)
    for at, peak in ((0.4, 5.0), (2.0, -5.0), (2.5, -5.0), (4.1, 5.0)):
        near = np.abs(time - at) < 0.1
        assert np.abs(acceleration[near]).max() == pytest.approx(5.0, rel=0.01)
        assert np.sign(acceleration[near].sum()) == np.sign(peak)


def test_a_large_torque_moves_the_load_as_its_transfer_function_says():
    """The torque again from the load's angle by the inverse of P_l, in open loop."""
    t = np.arange(3000) * STEP
    u = np.where(t < 1.0, np.sin(2.0 * np.pi * t) ** 3, 0.0)
    found = run(EXACT, 0.0 * u, 100.0 * u, disturbed=False, closed=False)
    s, model = laplace(len(u)), TwoMass()
    below = np.exp(-(np.abs(s / (2.0 * np.pi * 15.0)) ** 4)).astype(complex)
    torque = by_frequency(below * model.torque_over_load(s), found.load)
    expected, middle = by_frequency(below, 100.0 * u), slice(100, 900)
    # LuGre friction is a thousandth of it, a count of the load's encoder half of one per cent.
    np.testing.assert_allclose(torque[middle], expected[middle], atol=1.5)


def test_encoders_read_whole_counts():
    _, q = reference()
    found = run(DEVELOPED, 80.0 * q, 0.0 * q)
    for angle, count in ((found.motor, MOTOR_COUNT), (found.load, LOAD_COUNT)):
        np.testing.assert_allclose(angle / count, np.round(angle / count), atol=1e-6)
    assert np.abs(found.load - found.true_load).max() <= LOAD_COUNT


def test_the_transmission_error_twists_the_load_by_its_amplitude():
    """A of 1 mrad at a slow ramp: load minus theta / N swings by A, at twice the motor's turns."""
    ramp = np.arange(8000) * STEP * 80.0 * 0.05
    sizes = [
        np.ptp((one.load - one.motor / 80.0)[4000:])
        for one in (
            run(Individual(amplitude=a), ramp, 0.0 * ramp, disturbed=False) for a in (0.0, 1e-3)
        )
    ]
    assert sizes[1] - sizes[0] == pytest.approx(2e-3, rel=0.15)


@pytest.mark.parametrize("torque", [None, "motor", "load"])
def test_each_law_learns_the_bench_to_a_few_counts(torque):
    sizes = [rms_and_peak(error)[0] for error, _ in DualStage(torque=torque).runs(DEVELOPED)]
    assert sizes[-1] < 0.1 * sizes[0]
    assert sizes[-1] < 0.5e3 * LOAD_COUNT


def test_torque_learning_cancels_what_the_model_does_not_have():
    """In the last run the feedback has less to do than in the first."""
    first, *_, last = (done.feedback for _, done in DualStage(torque="motor").runs(DEVELOPED))
    assert np.std(last) < 0.5 * np.std(first)


def test_the_free_number_is_chosen_by_the_first_run_of_development():
    firsts = [
        rms_and_peak(next(DualStage().runs(Individual.drawn(seed, AMPLITUDE), 1))[0])[0]
        for seed in range(3)
    ]
    assert np.median(firsts) == pytest.approx(0.354, abs=0.002)


@pytest.fixture(scope="module")
def shaken():
    """Twelve seconds of the chirp: to 3.3 Hz."""
    torque = chirp()[:12_000]
    individual = Individual.drawn(0, CHIRP_AMPLITUDE)
    done = run(individual, 0.0 * torque, torque, disturbed=False, closed=False)
    return done, measured(done, torque, np.random.default_rng(0))


def test_both_filters_know_the_load_better_than_the_motor_does(shaken):
    done, seen = shaken
    off = [
        np.std(one - done.true_load)
        for one in (done.motor / 80.0, dkf(TwoMass(), seen), kkf(TwoMass(), seen))
    ]
    assert off[1] < 0.8 * off[0]
    assert off[2] < off[0]


def test_wrong_parameters_hurt_the_model_and_not_the_kinematics(shaken):
    done, seen = shaken
    wrong = TwoMass().scaled(k=0.8, Jl=1.2)
    right, off = (np.std(dkf(m, seen) - done.true_load) for m in (TwoMass(), wrong))
    assert off > 1.2 * right
    np.testing.assert_array_equal(kkf(wrong, seen), kkf(TwoMass(), seen))
