"""Subspace models of several inputs and outputs: the truth, its order, its noise."""

import control
import numpy as np
import pytest

from armside.ilc.identification.arx import Information
from armside.ilc.identification.innovations_form import InnovationsForm, states
from armside.ilc.identification.structures import Candidate, Structure
from armside.ilc.identification.subspace import (
    bootstrap_response_deviation,
    fit_subspace,
    rank_subspace_orders,
)
from armside.ilc.workbench.input_output import InputOutput
from armside.scripts.figures.identified_plant import _response

STEP, OMEGA = 0.004, np.linspace(0.1, 3.0, 8)
RNG = np.random.default_rng(0)
TRUE = InnovationsForm(
    A=np.array([[0.9, 0.3, 0, 0], [-0.3, 0.9, 0, 0], [0, 0, 0.7, 0.2], [0, 0, 0, -0.4]]),
    B=RNG.standard_normal((4, 2)),
    C=RNG.standard_normal((3, 4)),
    D=RNG.standard_normal((3, 2)),
    K=0.03 * RNG.standard_normal((4, 3)),
    S=0.1 * np.eye(3),
    sample_time=STEP,
)
"""Four states, two inputs, three outputs; a resonance at 13 Hz with 16 % damping."""


def record(rng, n=800, noise=1.0):
    u = rng.standard_normal((n, 2))
    e = noise * rng.standard_normal((n, 3)) @ np.linalg.cholesky(TRUE.S).T
    return u, TRUE.simulate(u) + states(TRUE.A, e @ TRUE.K.T) @ TRUE.C.T + e


def test_without_noise_the_response_is_exact():
    fit = fit_subspace(*record(np.random.default_rng(1), 300, 0.0), STEP, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=1e-10)
    assert fit.singular_values[4] < 1e-12 * fit.singular_values[3]
    assert not fit.warnings


def test_the_realisation_of_an_impulse_is_that_of_python_control():
    """Eigensystem realisation of the same impulse response, by another program."""
    impulse = np.stack([TRUE.simulate(np.eye(60, 1) * unit) for unit in np.eye(2)], axis=2)
    theirs, _ = control.eigensys_realization(impulse.transpose(1, 2, 0), 4, dt=True)
    expected = theirs(np.exp(1j * OMEGA)).transpose(2, 0, 1)
    ours = fit_subspace(*record(np.random.default_rng(1), 300, 0.0), STEP, 4, feedthrough=True)
    np.testing.assert_allclose(ours.model.response(OMEGA), expected, atol=1e-8)


def test_dynamics_and_noise_are_found_in_noise():
    rng = np.random.default_rng(2)
    assert np.abs(np.linalg.eigvals(TRUE.A - TRUE.K @ TRUE.C)).max() < 1.0
    fit = fit_subspace(*record(rng, 3000), STEP, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=0.1)
    np.testing.assert_allclose(fit.model.S, TRUE.S, atol=0.01)
    assert not fit.warnings


def test_order_by_information_is_that_of_the_truth_and_too_low_an_order_is_named():
    u, y = record(np.random.default_rng(3))
    ranked = rank_subspace_orders(u, y, STEP, range(2, 7), Information.BIC, feedthrough=True)
    assert ranked[0].model.order == 4
    low = next(fit for fit in ranked if fit.model.order == 2)
    assert "the innovations are not white" in low.warnings[0]


def test_what_the_inputs_explain_of_the_innovations_is_said():
    """A direct term that is not fitted: of white inputs the innovations are white all the same."""
    rng = np.random.default_rng(8)
    u, y = record(rng, 1000, 3.0)
    fit = fit_subspace(u, y, STEP, 4)
    assert fit.whiteness is not None
    assert fit.whiteness.is_uncorrelated
    assert [text for text in fit.warnings if "feedthrough left out" in text]
    right = [fit_subspace(*record(rng, 1000), STEP, 4, feedthrough=True) for _ in range(20)]
    assert sum(bool(each.warnings) for each in right) <= 2
    assert 0.1 < np.median([each.independence or 0.0 for each in right]) <= 1.0


def test_bootstrapped_deviations_are_the_scatter_of_repeated_fits():
    rng = np.random.default_rng(4)
    fits = [fit_subspace(*record(rng, 400), STEP, 4, feedthrough=True) for _ in range(30)]
    scatter = np.std([np.abs(fit.model.response(OMEGA)) for fit in fits], axis=0, ddof=1)
    u, _ = record(rng, 400)
    said = bootstrap_response_deviation(fits[0], u, OMEGA, rng, repeats=30)
    assert np.median(said / scatter) == pytest.approx(1.0, abs=0.15)


def test_the_band_that_is_drawn_holds_the_true_response_at_its_rate():
    """Magnitudes at 8 frequencies, 6 entries, 12 records; 95 % as `identify-plant` draws them."""
    rng, inside = np.random.default_rng(9), []
    for _ in range(12):
        u, y = record(rng, 400)
        fit = fit_subspace(u, y, STEP, 4, feedthrough=True)
        made = InputOutput(u=u, y=y, sample_time=STEP)
        best = Candidate.of(Structure.SUBSPACE, fit, u, y)
        magnitude, band = _response(best, made, OMEGA, 10, rng)
        true = np.abs(TRUE.response(OMEGA)).reshape(magnitude.shape)
        inside.append(np.abs(magnitude - true) < band)
    assert 0.90 <= np.mean(inside) <= 0.99


def test_a_start_that_is_not_rest_is_fitted():
    u, y = record(np.random.default_rng(5), 500, 0.0)
    fit = fit_subspace(u[100:], y[100:], STEP, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=1e-9)
    left = fit.model.innovations(u[100:], y[100:], fit.start)
    np.testing.assert_allclose(left, 0.0, atol=1e-9)


def test_a_model_that_is_not_stable_is_found_and_said():
    one = np.ones((1, 1))
    growing = InnovationsForm(
        A=1.02 * one, B=one, C=one, D=0.0 * one, K=0.0 * one, S=one, sample_time=STEP
    )
    u = np.random.default_rng(7).standard_normal((200, 1))
    fit = fit_subspace(u, growing.simulate(u), STEP, 1)
    assert fit.model.poles == pytest.approx([1.02])
    assert [text for text in fit.warnings if "the model is not stable" in text]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"order": 30}, "order must be from 1 to below 30, got 30"),
        ({"n": 100}, "a horizon of 10 needs more than 100 samples"),
        ({"u": np.zeros((800, 2))}, "may be zero throughout"),
        ({"u": np.ones((800, 2))}, "do not excite all inputs"),
    ],
)
def test_data_that_say_too_little_are_refused(change, message):
    u, y = record(np.random.default_rng(6), change.get("n", 800))
    with pytest.raises(ValueError, match=message):
        fit_subspace(change.get("u", u), y, STEP, change.get("order", 4))
