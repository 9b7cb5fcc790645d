"""Output error finds the model behind the data, also where one-step prediction does not."""

import numpy as np
import pytest

from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order import fit_first_order, fit_of
from armside.ilc.measures.norms import circle_ripple
from armside.ilc.models.system import System

STEP = 0.004
THESIS = System(np.array([0, 0, 0, 0, 0, 0.5083]), np.array([1.0, -0.4884]), STEP)


@pytest.fixture
def smooth_input():
    """Two corrections as learning leaves them: nothing above 10 Hz."""
    t = STEP * np.arange(400)[:, None]
    window = np.sin(np.pi * t / t[-1]) ** 2
    return window * np.sin(2 * np.pi * np.array([1.3, 3.1]) * t + [0.0, 1.0])


def test_the_model_of_the_thesis_is_found_again(smooth_input):
    found = fit_first_order(smooth_input, THESIS.simulate(smooth_input), STEP)
    assert found.delay == 5
    assert found.pole == pytest.approx(0.4884, abs=1e-4)
    assert found.static_gain == pytest.approx(THESIS.static_gain, abs=1e-5)
    assert found.fit == pytest.approx(1.0, abs=1e-4)
    assert found.total_delay == pytest.approx(5 + 0.4884 / 0.5116, abs=1e-3)


def test_output_noise_biases_output_error_less_than_arx(smooth_input):
    rng = np.random.default_rng(0)
    y = THESIS.simulate(smooth_input)
    y = y + 0.02 * rng.standard_normal(y.shape)
    ours = fit_first_order(smooth_input, y, STEP)
    arx = fit_arx(smooth_input, y, STEP, na=1, nb=1, nk=5)
    assert ours.total_delay == pytest.approx(5.95, abs=0.3)
    assert abs(ours.static_gain - THESIS.static_gain) < 0.01
    pole_of_arx = -arx.coefficients[0]
    found = fit_first_order(smooth_input, y, STEP, delays=[5])
    assert abs(found.pole - 0.4884) < 0.5 * abs(pole_of_arx - 0.4884)


def test_fit_is_one_for_the_ground_truth_and_zero_for_the_mean(smooth_input):
    y = THESIS.simulate(smooth_input)
    assert fit_of(THESIS, smooth_input, y) == pytest.approx(1.0)
    nothing = System(np.array([0.0]), np.array([1.0]), STEP)
    centred = y - y.mean(axis=0)
    assert fit_of(nothing, smooth_input, centred) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("u", "y", "message"),
    [
        (np.ones((9, 1)), np.ones((8, 1)), "one shape"),
        (np.zeros((9, 1)), np.ones((9, 1)), "zero throughout"),
    ],
)
def test_data_without_excitation_are_refused(u, y, message):
    with pytest.raises(ValueError, match=message):
        fit_first_order(u, y, STEP)


def test_no_delay_to_choose_from_is_refused():
    with pytest.raises(ValueError, match="delays must not be empty"):
        fit_first_order(np.ones((9, 1)), np.ones((9, 1)), STEP, delays=[])


def test_ripple_is_the_rms_of_the_harmonics_inside_the_band():
    turn_time, n = 0.8, 800
    t = turn_time * np.arange(n) / n
    radii = 5e-3 + 1e-4 * np.sin(2 * np.pi * 7.5 * t) + 3e-4 * np.sin(2 * np.pi * 2.5 * t)
    assert circle_ripple(radii, turn_time, 5.0, 14.0) == pytest.approx(1e-4 / np.sqrt(2))
    assert circle_ripple(radii, turn_time, 9.0, 14.0) == pytest.approx(0.0, abs=1e-12)


def test_the_95_percent_intervals_cover_the_ground_truth_95_percent_of_the_time():
    rng = np.random.default_rng(0)
    u = System(np.full(5, 0.2), np.ones(1), STEP).simulate(rng.standard_normal((300, 1)))
    clean, inside = THESIS.simulate(u), []
    for _ in range(100):
        y = clean + rng.normal(0.0, 0.05, clean.shape)
        low, high = fit_first_order(u, y, STEP, delays=[5]).confidence().T
        inside.append((low < [0.5083, 0.4884]) & (high > [0.5083, 0.4884]))
    # 95 % of 200 with a standard deviation of 1.5 %, widened by the correlation of the two
    assert 0.90 <= np.mean(inside) <= 0.99


@pytest.mark.parametrize(
    ("pole", "warned"), [(0.985, True), (0.995, True), (-0.4, True), (0.5, False)]
)
def test_a_pole_beyond_the_search_is_said(smooth_input, pole, warned):
    system = System(np.array([0.0, 1.0 - pole]), np.array([1.0, -pole]), STEP)
    rng = np.random.default_rng(1)
    u = smooth_input + 0.3 * rng.standard_normal(smooth_input.shape)
    y = system.simulate(u) + 1e-4 * rng.standard_normal(u.shape)
    found = fit_first_order(u, y, STEP)
    assert any("end of the search" in text for text in found.warnings) == warned


def test_friction_in_the_data_is_seen_in_the_simulation_error(smooth_input):
    y = THESIS.simulate(smooth_input)
    found = fit_first_order(smooth_input, y + 0.05 * np.sign(y), STEP)
    assert any("not white" in text for text in found.warnings)
