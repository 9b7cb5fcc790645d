"""ARX and output error, on records of one run and on learning data."""

import numpy as np
import pytest

from armside.ilc.identification.arx import Information, fit_arx, select_arx
from armside.ilc.identification.first_order_lag import (
    LearningRecord,
    fit_first_order,
    fit_of,
    fit_of_each,
    identify,
    learning_data,
)
from armside.ilc.models.system import System

from .signals import ARX, T_S

"""Thesis (9.12)."""


def data(seed, noise=0.02, n=1500, experiments=1):
    """Input with learning's low-pass character, equation noise as ARX assumes it."""
    rng = np.random.default_rng(seed)
    white = rng.standard_normal((n, experiments))
    u = System([0.2, 0.2, 0.2, 0.2, 0.2], [1], T_S).simulate(white)
    e = System([1], ARX.a, T_S).simulate(rng.normal(0, noise, u.shape))
    return u, ARX.simulate(u) + e


def test_the_servo_of_chapter_9_is_recovered_from_noisy_data():
    fit = select_arx(*data(0), T_S)[0]
    assert (fit.model.orders.na, fit.model.orders.nb, fit.model.orders.nk) == (1, 1, 5)
    np.testing.assert_allclose(
        fit.model.theta, [-0.4884, 0.5083], atol=4 * fit.standard_errors.max()
    )
    assert fit.noise_variance == pytest.approx(0.02**2, rel=0.1)


def test_a_higher_order_must_earn_its_coefficients():
    u, y = data(1)
    fits = select_arx(u, y, T_S, criterion=Information.BIC)
    orders = [(fit.model.orders.na, fit.model.orders.nb, fit.model.orders.nk) for fit in fits]
    assert orders.index((1, 1, 5)) < orders.index((2, 1, 5)) < orders.index((1, 1, 3))


def test_the_model_is_validated_on_another_experiment():
    fit = fit_arx(*data(0), T_S, na=1, nb=1, nk=5)
    u, y = data(99, experiments=3)
    good = fit_of_each(fit.system, u, y)
    wrong = fit_of_each(System([0, 0.5083], [1, -0.4884], T_S), u, y)
    assert good.shape == (3,)
    assert (good > 0.9).all()
    assert (wrong < 0.4).all()


def test_noise_on_the_output_is_named_where_it_makes_the_intervals_wrong():
    """Equation noise is what ARX assumes; white output noise biases it (coverage was 13 %)."""
    right = [fit_arx(*data(seed, n=500), T_S, na=1, nb=1, nk=5).warnings for seed in range(20)]
    assert sum(map(bool, right)) <= 2  # a test at 1 %

    def on_output(seed):
        u, _ = data(seed, noise=0.0, n=500)
        noise = np.random.default_rng(1000 + seed).normal(0.0, 0.1, u.shape)
        return u, ARX.simulate(u) + noise

    wrong = [fit_arx(*on_output(seed), T_S, na=1, nb=1, nk=5).warnings for seed in range(20)]
    assert sum(map(bool, wrong)) >= 18
    assert "residuals are not white" in wrong[0][0]


def test_information_criteria_are_those_of_the_textbook():
    """Akaike and Schwarz: n log(RSS / n) plus 2 or log n a coefficient."""
    u, y = data(2, n=200)
    fit = fit_arx(u, y, T_S, na=2, nb=1, nk=5)
    lags = np.column_stack((-y[4:-1, 0], -y[3:-2, 0], u[:-5, 0]))
    rss = np.linalg.lstsq(lags, y[5:, 0])[1][0]
    n = len(lags)
    assert fit.score(Information.AIC) == pytest.approx(n * np.log(rss / n) + 2 * 3)
    assert fit.score(Information.BIC) == pytest.approx(n * np.log(rss / n) + np.log(n) * 3)


@pytest.fixture
def smooth_input():
    """Two corrections as learning leaves them: nothing above 10 Hz."""
    t = T_S * np.arange(400)[:, None]
    window = np.sin(np.pi * t / t[-1]) ** 2
    return window * np.sin(2 * np.pi * np.array([1.3, 3.1]) * t + [0.0, 1.0])


def test_output_noise_biases_output_error_less_than_arx(smooth_input):
    rng = np.random.default_rng(0)
    y = ARX.simulate(smooth_input)
    y = y + 0.02 * rng.standard_normal(y.shape)
    ours = fit_first_order(smooth_input, y, T_S)
    arx = fit_arx(smooth_input, y, T_S, na=1, nb=1, nk=5)
    assert ours.total_delay == pytest.approx(5.95, abs=0.3)
    assert abs(ours.static_gain - ARX.static_gain) < 0.01
    pole_of_arx = -arx.model.theta[0]
    found = fit_first_order(smooth_input, y, T_S, delays=[5])
    assert abs(found.pole - 0.4884) < 0.5 * abs(pole_of_arx - 0.4884)


def test_fit_is_one_for_the_ground_truth_and_zero_for_the_mean(smooth_input):
    y = ARX.simulate(smooth_input)
    assert fit_of(ARX, smooth_input, y) == pytest.approx(1.0)
    nothing = System(np.array([0.0]), np.array([1.0]), T_S)
    centred = y - y.mean(axis=0)
    assert fit_of(nothing, smooth_input, centred) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("pole", "warned"), [(0.985, True), (0.995, True), (-0.4, True), (0.5, False)]
)
def test_a_pole_beyond_the_search_is_said(smooth_input, pole, warned):
    system = System(np.array([0.0, 1.0 - pole]), np.array([1.0, -pole]), T_S)
    rng = np.random.default_rng(1)
    u = smooth_input + 0.3 * rng.standard_normal(smooth_input.shape)
    y = system.simulate(u) + 1e-4 * rng.standard_normal(u.shape)
    found = fit_first_order(u, y, T_S)
    assert any("end of the search" in text for text in found.warnings) == warned


def test_friction_in_the_data_is_seen_in_the_simulation_error(smooth_input):
    y = ARX.simulate(smooth_input)
    found = fit_first_order(smooth_input, y + 0.05 * np.sign(y), T_S)
    assert any("not white" in text for text in found.warnings)


def experiment(seed, n_samples=300, motion_end=250, dtype=np.float64):
    """An experiment on the model of the thesis, with an arbitrary repeating error."""
    u, e_0 = np.random.default_rng(seed).standard_normal((2, n_samples, 6))
    u = System([0.2] * 5, [1], T_S).simulate(u)
    arrays = (u, e_0, e_0 - ARX.simulate(u))
    return LearningRecord(*(array.astype(dtype) for array in arrays), motion_end)


def test_learning_data_are_sums_of_corrections_and_of_the_changes_of_the_output():
    ones = np.ones((4, 2))
    records = [LearningRecord(ones, 5 * ones, ones, 4), LearningRecord(2 * ones, 7 * ones, ones, 3)]
    u, y = learning_data(records)
    np.testing.assert_array_equal(u, 3 * ones[:3])
    np.testing.assert_array_equal(y, 10 * ones[:3])


def test_records_of_different_lengths_end_with_the_first_motion():
    u, y = learning_data([experiment(0), experiment(1, n_samples=400, motion_end=210)], [3, 5])
    assert u.shape == y.shape == (210, 2)


def test_the_model_behind_the_data_is_identified():
    found = identify([experiment(seed) for seed in range(3)], T_S, motors=(3, 5))
    assert found.delay == 5
    assert found.pole == pytest.approx(0.4884, abs=1e-4)
    assert found.fit > 0.9999


def test_single_precision_is_summed_as_stored():
    records = [experiment(seed, dtype=np.float32) for seed in range(3)]
    u, y = learning_data(records, [3, 5])
    assert u.dtype == y.dtype == np.float64
    expected = sum((r.first_error - r.last_error)[:250, [3, 5]] for r in records)
    np.testing.assert_array_equal(y, expected.astype(np.float64))
    assert identify(records, T_S, [3, 5]).pole == fit_first_order(u, y, T_S).pole
