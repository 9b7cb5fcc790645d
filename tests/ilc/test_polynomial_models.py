"""Polynomial models and subspace identification."""

from dataclasses import replace
from typing import NamedTuple

import control
import numpy as np
import pytest

from armside.ilc.identification.arx import Information
from armside.ilc.identification.innovations_form import InnovationsForm, refined, states
from armside.ilc.identification.polynomial import Orders, Polynomials
from armside.ilc.identification.polynomial_fit import fit_polynomial
from armside.ilc.identification.structures import (
    Candidate,
    Structure,
    rank_by_validation,
    rank_orders,
    validation_error,
)
from armside.ilc.identification.subspace import (
    fit_subspace,
    rank_subspace_orders,
)
from armside.ilc.models.system import System
from armside.ilc.workbench.input_output import InputOutput
from armside.scripts.figures.identified_plant import _response

from .signals import T_S

NOISE = 0.1
B, C, D = [0.2, 0.1], [1.0, 0.5], [1.0, -0.9]
A = [1.0, -1.5, 0.7]
F = np.poly([0.95 * np.exp(0.3j), 0.95 * np.exp(-0.3j), 0.5]).real
"""A resonance at 12 Hz with 16 % damping, and a lag."""


def of(b, a):
    return System(np.array(b, dtype=float), np.array(a, dtype=float), T_S)


class Case(NamedTuple):
    orders: Orders
    denominator: list[float]
    noise: System
    truth: list[float]


CASES = {
    "output error": Case(Orders.output_error(2, 3, 2), list(F), of([1.0], [1.0]), [*B, *F[1:]]),
    "ARMAX": Case(Orders.armax(2, 2, 1, 2), A, of(C, A), [*A[1:], *B, C[1]]),
    "Box-Jenkins": Case(
        Orders.box_jenkins(2, 1, 1, 3, 2), list(F), of(C, D), [*B, C[1], D[1], *F[1:]]
    ),
}


def record(case, rng, n=400, noise=NOISE):
    u = of(np.full(5, 0.2), [1.0]).simulate(rng.standard_normal((n, 1)))
    system = of([0, 0, *B], case.denominator)
    return u, system.simulate(u) + case.noise.simulate(noise * rng.standard_normal(u.shape))


@pytest.fixture(params=CASES, ids=str)
def case(request):
    return CASES[request.param]


def test_the_gradient_is_the_difference_quotient(case):
    u, y = record(case, np.random.default_rng(0))
    theta = 1.01 * np.array(case.truth)
    exact = Polynomials(case.orders, theta, T_S).gradient(u, y)
    for i, h in enumerate(1e-6 * np.eye(len(theta))):
        ends = [Polynomials(case.orders, theta + s * h, T_S) for s in (1, -1)]
        plus, minus = (end.prediction_error(u, y) for end in ends)
        np.testing.assert_allclose((plus - minus) / 2e-6, exact[:, :, i], atol=1e-5)


def test_without_noise_the_fit_is_exact():
    """Orders 1 to 6 with poles anywhere to 0.97: no start ends in a local minimum."""
    rng = np.random.default_rng(1)
    for order in (1, 2, 4, 6):
        pairs = rng.uniform(0.5, 0.97, order // 2) * np.exp(1j * rng.uniform(0.1, 2.5, order // 2))
        poles = [*pairs, *pairs.conj(), *rng.uniform(0.2, 0.9, order % 2)]
        true = of([0, 0, *rng.standard_normal(order)], np.poly(poles).real)
        u = rng.standard_normal((500, 1))
        fit = fit_polynomial(u, true.simulate(u), T_S, Orders.output_error(order, order, 2))
        np.testing.assert_allclose(fit.system.a, true.a, atol=1e-7)
        np.testing.assert_allclose(fit.system.b, true.b, atol=1e-7)


@pytest.mark.parametrize("seed", [0, 23])
def test_a_start_that_ends_in_a_local_minimum_is_not_taken(seed):
    """The least sum of squares is no larger than that of the truth, which is the noise.

    Of two starts, one ends above it: the second with seed 0, the first with seed 23.
    """
    rng = np.random.default_rng(seed)
    pairs = rng.uniform(0.5, 0.97, 2) * np.exp(1j * rng.uniform(0.1, 2.5, 2))
    true = of([0, 0, *rng.standard_normal(4)], np.poly([*pairs, *pairs.conj()]).real)
    u = rng.standard_normal((200, 1))
    exact = true.simulate(u)
    noise = 0.5 * exact.std() * rng.standard_normal(u.shape)
    orders = Orders.output_error(4, 4, 2)
    fit = fit_polynomial(u, exact + noise, T_S, orders)
    assert fit.noise_variance * (u.size - orders.count) <= np.square(noise).sum()


def test_a_model_that_is_right_is_seldom_doubted(case):
    """Two tests at 1 % on 20 records."""
    rng = np.random.default_rng(2)
    fits = [fit_polynomial(*record(case, rng), T_S, case.orders) for _ in range(20)]
    assert sum(bool(fit.warnings) for fit in fits) <= 2


def test_the_deviation_of_the_response_is_the_scatter_of_repeated_fits():
    case, rng = CASES["Box-Jenkins"], np.random.default_rng(3)
    omega = np.array([0.1, 0.5, 1.5])
    fits = [fit_polynomial(*record(case, rng), T_S, case.orders) for _ in range(50)]
    scatter = np.std([np.abs(fit.system.response(omega)) for fit in fits], axis=0)
    said = np.mean([fit.response_deviation(omega) for fit in fits], axis=0)
    np.testing.assert_allclose(said, scatter, rtol=0.35)  # 10 % of a scatter of 50, three times


def test_a_wrong_model_of_the_noise_is_named_with_its_effect():
    """Output error on coloured noise keeps the response; ARX on it is biased."""
    case, rng = CASES["Box-Jenkins"], np.random.default_rng(4)
    u, y = record(case, rng, n=2000)
    simulated = fit_polynomial(u, y, T_S, Orders.output_error(2, 3, 2))
    assert simulated.independence is not None
    assert simulated.independence > 0.01
    assert [text for text in simulated.warnings if "their intervals are wrong" in text]
    biased = fit_polynomial(u, y, T_S, Orders(na=3, nb=2, nk=2))
    assert [text for text in biased.warnings if "coefficients are biased" in text]
    true = of([0, 0, *B], case.denominator).response([0.3])
    error = [abs(fit.system.response([0.3]) - true)[0] for fit in (simulated, biased)]
    assert error[0] < 0.3 * error[1]


def test_an_order_too_low_is_named_by_the_input_that_explains_its_residuals():
    u, y = record(CASES["output error"], np.random.default_rng(5), n=1000)
    fit = fit_polynomial(u, y, T_S, Orders.output_error(2, 1, 2))
    assert "the input explains part of the residuals" in fit.warnings[0]


def test_criteria_and_validation_choose_the_order_of_the_truth():
    case, rng = CASES["output error"], np.random.default_rng(6)
    u, y = record(case, rng, n=600, noise=0.05)
    candidates = [Orders.output_error(2, nf, nk) for nf in (1, 2, 3, 4) for nk in (1, 2)]
    by_mdl = rank_orders(u, y, T_S, candidates, Information.BIC)
    assert by_mdl[0].model.orders == case.orders
    by_aic = rank_orders(u, y, T_S, candidates, Information.AIC)
    assert by_aic[0].model.orders.nf >= 3
    other = record(case, rng, n=600, noise=0.05)
    ranked = rank_by_validation(by_mdl, *other)
    assert ranked[0].model.orders.nf >= 3
    assert validation_error(ranked[0], *other) < 0.9 * validation_error(ranked[-1], *other)
    with pytest.raises(ValueError, match="candidates must not be empty"):
        rank_orders(u, y, T_S, [])


@pytest.mark.parametrize(
    ("n", "orders", "message"),
    [
        (8, Orders.output_error(3, 3, 0), "6 coefficients need more than 8 samples"),
        (100, Orders(na=1, nb=2, nk=0), "do not excite 3 coefficients"),
    ],
)
def test_data_that_say_too_little_are_refused(n, orders, message):
    u = np.zeros((n, 1))
    with pytest.raises(ValueError, match=message):
        fit_polynomial(u, np.random.default_rng(7).standard_normal((n, 1)), T_S, orders)
    with pytest.raises(ValueError, match="orders must be >= 0 and nb >= 1"):
        Orders.output_error(0, 1, 1)


OMEGA = np.linspace(0.1, 3.0, 8)
RNG = np.random.default_rng(0)
TRUE = InnovationsForm(
    A=np.array([[0.9, 0.3, 0, 0], [-0.3, 0.9, 0, 0], [0, 0, 0.7, 0.2], [0, 0, 0, -0.4]]),
    B=RNG.standard_normal((4, 2)),
    C=RNG.standard_normal((3, 4)),
    D=RNG.standard_normal((3, 2)),
    K=0.03 * RNG.standard_normal((4, 3)),
    S=0.1 * np.eye(3),
    sample_time=T_S,
)
"""Four states, two inputs, three outputs; a resonance at 13 Hz with 16 % damping."""


def noisy_record(rng, n=800, noise=1.0):
    u = rng.standard_normal((n, 2))
    e = noise * rng.standard_normal((n, 3)) @ np.linalg.cholesky(TRUE.S).T
    return u, TRUE.system.simulate(u) + states(TRUE.A, e @ TRUE.K.T) @ TRUE.C.T + e


def test_without_noise_the_response_is_exact():
    fit = fit_subspace(*noisy_record(np.random.default_rng(1), 300, 0.0), T_S, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=1e-10)
    assert fit.singular_values[4] < 1e-12 * fit.singular_values[3]
    assert not fit.warnings


def test_the_realisation_of_an_impulse_is_that_of_python_control():
    """Eigensystem realisation of the same impulse response, by another program."""
    impulse = np.stack([TRUE.system.simulate(np.eye(60, 1) * unit) for unit in np.eye(2)], axis=2)
    theirs, _ = control.eigensys_realization(impulse.transpose(1, 2, 0), 4, dt=True)
    expected = theirs(np.exp(1j * OMEGA)).transpose(2, 0, 1)
    ours = fit_subspace(*noisy_record(np.random.default_rng(1), 300, 0.0), T_S, 4, feedthrough=True)
    np.testing.assert_allclose(ours.model.response(OMEGA), expected, atol=1e-8)


def test_dynamics_and_noise_are_found_in_noise():
    rng = np.random.default_rng(2)
    assert np.abs(np.linalg.eigvals(TRUE.A - TRUE.K @ TRUE.C)).max() < 1.0
    fit = fit_subspace(*noisy_record(rng, 3000), T_S, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=0.1)
    np.testing.assert_allclose(fit.model.S, TRUE.S, atol=0.01)
    assert not fit.warnings


def test_order_by_information_is_that_of_the_truth_and_too_low_an_order_is_named():
    u, y = noisy_record(np.random.default_rng(3))
    ranked = rank_subspace_orders(u, y, T_S, range(2, 7), Information.BIC, feedthrough=True)
    assert ranked[0].model.order == 4
    low = next(fit for fit in ranked if fit.model.order == 2)
    assert "the innovations are not white" in low.warnings[0]


def test_what_the_inputs_explain_of_the_innovations_is_said():
    """A direct term that is not fitted: of white inputs the innovations are white all the same."""
    rng = np.random.default_rng(8)
    u, y = noisy_record(rng, 1000, 3.0)
    fit = fit_subspace(u, y, T_S, 4)
    assert fit.whiteness is not None
    assert fit.whiteness.is_uncorrelated
    assert [text for text in fit.warnings if "feedthrough left out" in text]
    right = [fit_subspace(*noisy_record(rng, 1000), T_S, 4, feedthrough=True) for _ in range(20)]
    assert sum(bool(each.warnings) for each in right) <= 2
    assert 0.1 < np.median([each.independence or 0.0 for each in right]) <= 1.0


def test_the_band_that_is_drawn_holds_the_true_response_at_its_rate():
    """Magnitudes at 8 frequencies, 6 entries, 12 records; 95 % as `identify-plant` draws them."""
    rng, inside = np.random.default_rng(9), []
    for _ in range(12):
        u, y = noisy_record(rng, 400)
        fit = fit_subspace(u, y, T_S, 4, feedthrough=True)
        made = InputOutput(u=u, y=y, sample_time=T_S)
        best = Candidate(Structure.SUBSPACE, fit, 1.0)
        magnitude, band = _response(best, made, OMEGA, 10, rng)
        true = np.abs(TRUE.response(OMEGA)).reshape(magnitude.shape)
        inside.append(np.abs(magnitude - true) < band)
    assert 0.90 <= np.mean(inside) <= 0.99


def test_a_start_that_is_not_rest_is_fitted():
    u, y = noisy_record(np.random.default_rng(5), 500, 0.0)
    fit = fit_subspace(u[100:], y[100:], T_S, 4, feedthrough=True)
    np.testing.assert_allclose(fit.model.response(OMEGA), TRUE.response(OMEGA), atol=1e-9)
    left = fit.model.innovations(u[100:], y[100:], fit.start)
    np.testing.assert_allclose(left, 0.0, atol=1e-9)


def test_a_model_that_is_not_stable_is_found_and_said():
    one = np.ones((1, 1))
    growing = InnovationsForm(
        A=1.02 * one, B=one, C=one, D=0.0 * one, K=0.0 * one, S=one, sample_time=T_S
    )
    u = np.random.default_rng(7).standard_normal((200, 1))
    fit = fit_subspace(u, growing.system.simulate(u), T_S, 1)
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
def test_data_that_determine_no_states_are_refused(change, message):
    u, y = noisy_record(np.random.default_rng(6), change.get("n", 800))
    with pytest.raises(ValueError, match=message):
        fit_subspace(change.get("u", u), y, T_S, change.get("order", 4))


def test_a_refined_gain_leaves_no_step_that_lowers_the_squares():
    """A second refinement begins where the first ended; six steps converge to a part of 1e-5."""
    u, y = noisy_record(np.random.default_rng(10), 400)

    def squares(K):
        K, B, D, start = refined(TRUE.A, TRUE.C, K, u, y, True)
        model = replace(TRUE, B=B, D=D, K=K)
        return K, np.square(model.innovations(u, y, start)).sum()

    K, first = squares(0.0 * TRUE.K)
    assert squares(K)[1] == pytest.approx(first, rel=2e-5)


def test_a_zero_outside_the_unit_circle_goes_to_its_mirror_image_or_to_the_bound():
    """F = (q - 2)(q - 1.01)(q - 0.5): 2 becomes 1/2, 1.01 becomes 0.95, and 0.5 stays."""
    orders = Orders.output_error(1, 3, 1)
    theta = np.concatenate(([1.0], np.poly([2.0, 1.01, 0.5])[1:]))
    made = Polynomials(orders, theta, T_S).with_stable_predictor(0.95)
    np.testing.assert_allclose(np.sort(np.roots(made.parts["f"])), [0.5, 0.5, 0.95], atol=1e-6)
    assert made.is_predictor_stable
