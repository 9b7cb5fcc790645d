"""Laws, designs and fits against independent formulas, and the defaults that users rely on."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete

from armside.ilc.analysis.robustness import PARAMETERS, monte_carlo
from armside.ilc.divergence import DIVERGENCE_RATIO, has_diverged
from armside.ilc.filters import ALL_PASS, End, ZeroPhaseButterworth
from armside.ilc.identification.arx import Information, fit_arx
from armside.ilc.identification.first_order import fit_first_order
from armside.ilc.laws import Heuristic
from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.laws.model_based import RegularisedInverse
from armside.ilc.laws.norm_optimal import RecordOptimal
from armside.ilc.laws.wrappers import Guarded
from armside.ilc.measures.norms import circle_ripple
from armside.ilc.models.system import System
from armside.ilc.models.two_mass import TwoMassJoint, TwoMassLoop
from armside.ilc.two_mass_study import learned

N, STEP = 64, 0.004
MIX = np.array([[1.0, 0.3], [-0.2, 0.8]])


class Gain:
    """Two outputs of two inputs: a constant mix behind one lag and a delay of three samples."""

    def __init__(self, mix=MIX, scale=1.0):
        self.mix = scale * np.asarray(mix)

    def response(self, omega):
        z = np.exp(1j * np.asarray(omega))
        return (z**-3 * 0.4 / (1 - 0.6 / z))[:, None, None] * self.mix


def inverse(**options):
    given = {"G": Gain(), "sample_time": STEP, "cutoff": 25.0, "output_weight": (1.0, 0.5)}
    return RegularisedInverse(**given | {"input_size": (2.0, 0.1)} | options)


def test_the_regularised_inverse_is_its_formula():
    """S (S G'W'WG S + rho)^-1 S G'W' W with rho relative to the response at rest."""
    law, omega = inverse(regularisation=0.05), np.linspace(0.0, np.pi, 9)
    W, S = np.diag([1.0, 0.5]), np.diag([2.0, 0.1])
    at_rest = np.linalg.norm(W @ Gain().response(np.zeros(1))[0] @ S, ord=2)
    for G, L in zip(Gain().response(omega), law.L(omega), strict=True):
        T = W @ G @ S
        inverted = np.linalg.inv(T.conj().T @ T + 0.05 * at_rest**2 * np.eye(2)) @ T.conj().T
        assert pytest.approx(S @ inverted @ W) == L


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_of_inputs_and_outputs_change_no_design(scale):
    """A plant in other units and inputs of that size: the correction is the same signal."""
    rng = np.random.default_rng(0)
    u, e = rng.standard_normal((2, N, 2))
    law = inverse()
    metres = inverse(G=Gain(scale=scale))
    assert metres(u, scale * e) == pytest.approx(law(u, e), rel=1e-6, abs=1e-9)
    sized = inverse(G=Gain(scale=1 / scale), input_size=(2.0 * scale, 0.1 * scale))
    assert sized(scale * u, e) == pytest.approx(scale * law(u, e), rel=1e-6, abs=1e-9 * scale)


def test_a_correction_stays_within_the_limit_of_each_input():
    law = inverse(limit=0.01)
    e = 100.0 * np.random.default_rng(1).standard_normal((N, 2))
    u = law(np.zeros((N, 2)), e)
    assert np.abs(u).max(axis=0) == pytest.approx([0.02, 0.001])
    free = inverse(limit=np.inf)(np.zeros((N, 2)), e)
    assert u == pytest.approx(np.clip(free, [-0.02, -0.001], [0.02, 0.001]))


def lifted(apply):
    """Matrix of a linear map of records (N, 2), row by row."""
    units = np.eye(2 * N).reshape(2 * N, N, 2)
    return np.stack([apply(unit).ravel() for unit in units], axis=1)


def test_the_record_optimal_law_minimises_its_criterion():
    """min |F W(e - G du)|^2 + rho |u + du|^2 + sigma |du|^2, in inputs of their size."""
    F = ZeroPhaseButterworth(30.0, STEP)
    law = RecordOptimal(
        G=Gain(),
        F=F,
        output_weight=(1.0, 0.5),
        input_size=(2.0, 0.1),
        correction_weight=0.02,
        change_weight=0.05,
    )
    rng = np.random.default_rng(2)
    window = np.hanning(N)[:, None]
    u, e = window * rng.standard_normal((2, N, 2))
    W, S = np.array([1.0, 0.5]), np.array([2.0, 0.1])
    omega = 2 * np.pi * np.fft.rfftfreq(2 * N)
    G = Gain().response(omega)

    def plant(v):
        V = np.fft.rfft(v * S, 2 * N, axis=0)
        return W * np.fft.irfft((G @ V[:, :, None])[:, :, 0], 2 * N, axis=0)[:N]

    T, filtered = lifted(plant), lifted(F)
    scale = np.linalg.norm(np.diag(W) @ G[0] @ np.diag(S), ord=2) ** 2
    rho, sigma = 0.02 * scale, 0.05 * scale
    weight = filtered @ filtered  # the law filters twice, forwards in time
    normal = T.T @ weight @ T + (rho + sigma) * np.eye(2 * N)
    right = T.T @ weight @ (W * e).ravel() - rho * (u / S).ravel()
    expected = u + S * np.linalg.solve(normal, right).reshape(N, 2)
    assert law(u, e) == pytest.approx(expected, rel=1e-3, abs=1e-3 * np.abs(expected).max())


def test_a_heavier_correction_and_a_heavier_change_each_make_smaller_steps():
    base = RecordOptimal(G=Gain(), F=ALL_PASS, output_weight=(1.0, 1.0), input_size=(1.0, 1.0))
    u, e = np.random.default_rng(3).standard_normal((2, N, 2))
    steps = {}
    for name in ("correction_weight", "change_weight"):
        sizes = [
            np.linalg.norm(replace(base, **{name: value})(0 * u, e)) for value in (1e-4, 1e-2, 1.0)
        ]
        assert sizes[0] > sizes[1] > sizes[2]
        steps[name] = replace(base, **{name: 1e3})(u, 0 * e)
    # without an error: weight on u pulls it to zero, weight on the change leaves it
    assert np.abs(steps["correction_weight"]).max() < 0.01 * np.abs(u).max()
    assert steps["change_weight"] == pytest.approx(u, abs=0.01)


class Step(FirstOrderLaw):
    """u + 0.5 e."""

    def __call__(self, correction, error, /):
        return correction + 0.5 * error


def guarded(sizes, **options):
    """Corrections after errors of these sizes, each a constant record, and the last memory."""
    law = Guarded(law=Step(), weight=(1.0, 0.0), **options)
    u, memory, found = np.zeros((4, 2)), None, []
    for size in sizes:
        u, memory = law.step(u, np.full((4, 2), float(size)), memory)
        found.append(u[0, 0])
    return found, memory


def test_a_guard_goes_back_to_the_best_correction_with_half_the_step():
    found, memory = guarded([1.0, 0.8, 1.5])
    # 0 + 0.5; + 0.4; then back to the correction of the best error, 0.5, with half of 0.4
    assert found == pytest.approx([0.5, 0.9, 0.5 + 0.5 * 0.4])
    assert (memory.size, memory.gain, memory.setbacks) == (0.8, 0.5, 1)


@pytest.mark.parametrize(("growth", "back"), [(1.199, False), (1.201, True)])
def test_an_error_a_fifth_above_the_best_is_growth(growth, back):
    _, memory = guarded([1.0, growth])
    assert memory.setbacks == int(back)
    assert memory.size == 1.0


def test_after_three_setbacks_the_best_is_repeated():
    found, memory = guarded([1.0, 2.0, 2.0, 2.0, 2.0])
    assert memory.setbacks >= 3
    assert found[3:] == pytest.approx([0.0, 0.0])
    assert (Guarded(law=Step(), weight=(1.0,)).tolerance, memory.gain) == (
        1.2,
        0.5**memory.setbacks,
    )


def test_columns_of_no_weight_do_not_count_for_a_guard():
    law = Guarded(law=Step(), weight=(2.0, 0.0))
    assert law.size(np.array([[3.0, 100.0], [4.0, 100.0]])) == pytest.approx(2 * np.sqrt(12.5))


@pytest.mark.parametrize(("ratio", "diverged"), [(2.99, False), (3.01, True)])
def test_learning_has_diverged_above_three_times_its_first_error(ratio, diverged):
    assert DIVERGENCE_RATIO == 3.0
    first = np.array([1.0, 2.0, 3.0])
    size = first * np.array([0.1, ratio, 0.1])  # one motor is enough
    assert has_diverged(size, first) is diverged
    assert has_diverged(np.array([1.0, np.nan, 1.0]), first)


def test_a_heuristic_law_shifts_in_what_it_is_told():
    e = np.arange(1.0, 6.0)[:, None]
    for end, last in ((End.HOLD, 5.0), (End.ZERO, 0.0)):
        law = Heuristic(Q=ALL_PASS, gamma=0.5, delta=2, end=end)
        expected = 0.5 * np.array([3.0, 4.0, 5.0, last, last])
        assert law(np.zeros((5, 1)), e)[:, 0] == pytest.approx(expected)


# Identification and robustness


@pytest.mark.parametrize("pole", [0.3, 0.8, 0.95, 0.975])
def test_output_error_finds_a_first_order_response_exactly(pole):
    rng = np.random.default_rng(4)
    true = System(np.array([0.0, 0.0, 0.0, 1.02 * (1 - pole)]), np.array([1.0, -pole]), STEP)
    u = np.cumsum(rng.standard_normal((400, 2)), axis=0)
    found = fit_first_order(u, true.simulate(u), STEP)
    assert (found.delay, found.static_gain) == (3, pytest.approx(1.02, rel=1e-3))
    assert found.pole == pytest.approx(pole, abs=1e-4)
    assert found.total_delay == pytest.approx(3 + pole / (1 - pole), rel=1e-2)
    assert found.fit > 0.999


def test_the_fit_is_relative_to_the_deviation_from_the_mean():
    """An output that is noise about a large mean is not explained by a model of the mean."""
    rng = np.random.default_rng(5)
    u = np.ones((300, 1))
    y = 10.0 + rng.standard_normal((300, 1))
    assert fit_first_order(u, y, STEP, delays=[0]).fit < 0.3


def test_information_criteria_count_samples_and_coefficients():
    rng = np.random.default_rng(6)
    u = rng.standard_normal((200, 1))
    y = System(np.array([0.0, 0.5]), np.array([1.0, -0.7]), STEP).simulate(u)
    y = y + 0.1 * rng.standard_normal(y.shape)
    small, large = (fit_arx(u, y, STEP, na=1, nb=nb, nk=1, skip=6) for nb in (1, 5))
    for criterion, penalty in ((Information.AIC, 2.0), (Information.BIC, np.log(194))):
        apart = large.score(criterion) - small.score(criterion)
        # The likelihood has the variance over all samples, not over those that are left free.
        free = np.log((194 - 6) / (194 - 2))
        likelihood = 194 * (np.log(large.noise_variance / small.noise_variance) + free)
        assert apart - likelihood == pytest.approx(4 * penalty, rel=1e-6)


def test_uncertain_parameters_spread_by_what_is_asked():
    """Each factor is exp of a uniform number within +- log(1 + spread)."""
    law = Heuristic(Q=ZeroPhaseButterworth(6.0, 0.01), gamma=0.9, delta=5)
    found = monte_carlo(TwoMassLoop(), law, 0.3, 150, np.random.default_rng(7))
    assert PARAMETERS == ("k", "d", "Ja", "Jm", "fm", "kt")
    assert found.factors.shape == (150, 6)
    log = np.log(found.factors)
    width = np.log(1.3)
    assert np.abs(log).max() <= width
    assert np.abs(log).max() > 0.97 * width
    n = log.size
    assert log.std() == pytest.approx(width / np.sqrt(3), rel=5 / np.sqrt(2 * n))
    assert 0.0 <= found.fraction_converging <= 1.0


def test_the_reference_filter_stays_as_designed_when_the_joint_differs():
    from armside.ilc.analysis.robustness import _scaled

    loop = TwoMassLoop()
    other = _scaled(loop, {"k": 2.0, "fm": 0.5})
    assert (other.joint.k, other.joint.fm) == (10.0, pytest.approx(0.5 * 0.0713))
    assert other.F_r.b == pytest.approx(loop.F_r.b)


def test_a_wrong_stiffness_in_the_reference_filter_moves_the_arm_and_not_the_motor():
    """Fig. 8.11: twice the stiffness. The thesis's equations give 1.470 and 2.049 at k = 0."""
    right, wrong = (learned(17.0, stiffness_factor=f, iterations=2) for f in (1.0, 2.0))
    assert right.arm[0] == pytest.approx(1.46962, rel=2e-3)
    assert wrong.arm[0] == pytest.approx(2.04878, rel=2e-3)
    assert wrong.motor[2] / wrong.motor[0] == pytest.approx(
        right.motor[2] / right.motor[0], rel=0.2
    )


# Systems and measures


@pytest.mark.parametrize(("pole", "stable"), [(0.999, True), (1.0, False), (-1.0, False)])
def test_a_pole_on_the_unit_circle_is_not_stable(pole, stable):
    assert System(np.ones(1), np.array([1.0, -pole]), STEP).is_stable is stable


def test_the_joint_of_chapter_8_is_that_of_table_8_1():
    """Gunnarsson et al. 2007; (8.1), (8.2) as a state space, discretised by scipy."""
    joint = TwoMassJoint()
    rg, Jm, Ja, k, d, fm, kt = 0.2, 0.0021, 0.0991, 5.0, 0.25, 0.0713, 0.122
    A = np.array(
        [
            [0, 1, 0, 0],
            [-k / Ja, -d / Ja, rg * k / Ja, rg * d / Ja],
            [0, 0, 0, 1],
            [rg * k / Jm, rg * d / Jm, -(rg**2) * k / Jm, -(fm + rg**2 * d) / Jm],
        ]
    )
    B = np.array([[0.0], [0.0], [0.0], [kt / Jm]])
    found = joint.state_space
    assert found[0] == pytest.approx(A)
    assert found[1] == pytest.approx(B)
    Ad, Bd, *_ = cont2discrete((A, B, np.eye(4), np.zeros((4, 1))), 0.01)
    omega = np.array([0.05, 0.3, 1.0])
    z = np.exp(1j * omega)
    for i, system in ((2, joint.motor(0.01)), (0, joint.arm_from_voltage(0.01))):
        states = [np.linalg.solve(each * np.eye(4) - Ad, Bd)[i, 0] for each in z]
        assert system.response(omega) == pytest.approx(np.array(states), rel=1e-6)
    # without losses the two inertias keep their momentum: no torque, no change of rg p_a + p_m
    free = replace(joint, fm=0.0).state_space[0]
    momentum = np.array([0.0, rg * Ja, 0.0, Jm])
    assert momentum @ free @ np.array([0.3, -0.2, 0.5, 0.1]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("n", [196, 197])
def test_ripple_over_all_frequencies_is_the_standard_deviation_of_the_radius(n):
    """Parseval, for even and odd numbers of samples."""
    radii = 5e-3 + 1e-4 * np.random.default_rng(8).standard_normal(n)
    assert circle_ripple(radii, 0.785, 0.0, np.inf) == pytest.approx(radii.std(), rel=1e-9)
    t = np.arange(n) / n
    wave = 5e-3 + 1e-4 * np.sin(2 * np.pi * 8 * t)
    assert circle_ripple(wave, 0.785, 5.0, 14.0) == pytest.approx(1e-4 / np.sqrt(2))
    assert circle_ripple(wave, 0.785, 14.0, 100.0) == pytest.approx(0.0, abs=1e-12)
