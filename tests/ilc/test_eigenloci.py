"""Peaks over frequency with a bound, and eigenloci of coupled motors."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.analysis import criterion, eigenloci, heuristic_criterion
from armside.ilc.analysis.criterion import heuristic_gain
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.models.peak import AllPassPhase, peak
from armside.ilc.models.products import largest_singular_value
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, entries_of, random_matrix
from .test_dense_analysis import narrow_grid


def resonant(seed):
    """A lag with a resonance of damping 1e-5 to 0.03; and a grid that resolves it."""
    rng = np.random.default_rng(seed)
    damping, at = 10.0 ** rng.uniform(-5, -1.5), rng.uniform(0.1, 2.5)
    pole = np.exp(at * (1j - damping))
    lag = rng.uniform(0.2, 0.9)
    a = np.poly([pole, pole.conjugate(), lag]).real
    b = np.concatenate((np.zeros(rng.integers(1, 4)), rng.standard_normal(3)))
    T = System(b, a, T_S)
    T = T * (1.0 / abs(T.static_gain))
    near = at + (1.0 - abs(pole)) * np.tan(np.linspace(-1.57, 1.57, 20001))
    omega = np.concatenate((np.linspace(0.0, np.pi, 20001), near[(near > 0.0) & (near < np.pi)]))
    return T * np.sign(T.static_gain), np.unique(omega)


def test_the_phase_of_an_all_pass_grows_by_its_degree():
    poles = np.array([0.0, 0.5, -0.3, 0.999 * np.exp(0.7j), 0.999 * np.exp(-0.7j)])
    phase = AllPassPhase(poles)
    assert phase(np.array([np.pi])) - phase(np.array([0.0])) == pytest.approx(5 * np.pi)
    omega = phase.grid(0.1)
    assert np.diff(phase(omega)).max() < 0.2
    by_difference = (phase(omega + 1e-7) - phase(omega - 1e-7)) / 2e-7
    z = np.exp(1j * omega)[:, None]
    exact = ((1 - np.abs(poles) ** 2) / np.abs(z - poles) ** 2).sum(axis=1)
    np.testing.assert_allclose(by_difference, exact, rtol=1e-5)


def test_a_response_without_a_peak_is_bounded_in_few_points():
    found = peak(np.ones_like, np.zeros(5, dtype=complex))
    assert found.bound == pytest.approx(1.0, abs=1e-6)
    assert len(found.omega) < 1e5


COUPLED = SystemMatrix(
    (
        (System([0, 0.5], [1, -0.5], T_S), resonant(3)[0] * 0.02),
        (System([0, 0, 0.1], [1, -0.8], T_S), System([0, 0.3], [1, -0.7], T_S)),
    )
)


def test_coupled_motors_contract_by_the_largest_singular_value():
    Q, gamma, delta = ZeroPhaseButterworth((10.0, 20.0), T_S), np.array([0.7, 0.5]), (2, 1)
    ours = heuristic_criterion(COUPLED, gamma, delta, Q)
    omega = np.unique(np.concatenate((resonant(3)[1][::10], np.linspace(0, np.pi, 3000))))
    L = heuristic_gain(COUPLED, gamma, delta).response(omega)
    iteration = Q.response(omega)[:, :, None] * (np.eye(2) - L @ COUPLED.response(omega))
    fine = np.linalg.svd(iteration, compute_uv=False).max()
    assert ours.bound is not None
    assert fine <= ours.bound
    assert ours.bound == pytest.approx(fine, rel=1e-4)
    with pytest.raises(ValueError, match="needs one Q for all motors"):
        criterion(COUPLED.response(omega), L, Q.response(omega), omega)


SERVO = System(np.array([0, 0, 0.3]), np.array([1.0, -0.7]), T_S)
LOW = ZeroPhaseButterworth(20.0, T_S)


def dense_iteration(T, gamma, delta, Q, omega):
    """Q (I - gamma q^delta T) from the coefficients of each entry, (M, n, n)."""
    z = np.exp(-1j * omega)
    rows = [[np.polyval(s.b[::-1], z) / np.polyval(s.a[::-1], z) for s in row] for row in
            entries_of(T)]  # fmt: skip
    response = np.moveaxis(np.array(rows), 2, 0)
    LT = gamma * np.exp(1j * delta * omega)[:, None, None] * response
    return Q.response(omega)[:, None, None] * (np.eye(len(rows)) - LT)


@cases(6)
@given(
    n=st.sampled_from([1, 2, 3]), order=st.integers(1, 8), slowest=SLOWEST, damping=DAMPING,
    gamma=st.floats(0.05, 1.5), delta=st.integers(0, 6), seed=SEED,
)  # fmt: skip
def test_loci_are_the_eigenvalues_and_none_exceeds_the_bound(
    n, order, slowest, damping, gamma, delta, seed
):
    rng = np.random.default_rng(seed)
    T = random_matrix(rng, n, order, slowest, damping)
    if not T.is_stable:
        return
    found = eigenloci(T, gamma, delta, LOW)
    at = rng.integers(0, len(found.omega), 20)
    expected = np.linalg.eigvals(dense_iteration(T, gamma, delta, LOW, found.omega[at]))
    distance = np.abs(found.values[at][:, :, None] - expected[:, None, :])
    size = max(1.0, float(np.abs(expected).max()))
    assert max(distance.min(axis=1).max(), distance.min(axis=2).max()) <= 1e-5 * size
    omega = narrow_grid(T, LOW.poles)
    radius = np.abs(np.linalg.eigvals(dense_iteration(T, gamma, delta, LOW, omega))).max()
    assert found.bound is not None
    assert radius <= found.bound * (1 + AGREED)
    assert found.spectral_radius <= found.bound * (1 + AGREED)
    assert found.spectral_radius >= radius * (1 - AGREED)
    criterion = heuristic_criterion(T, gamma, delta, LOW)
    assert found.bound <= criterion.contraction * (1 + AGREED)


@pytest.mark.parametrize(("gamma", "expected"), [(0.4, True), (1.7, False)])
def test_loci_of_a_normal_iteration_say_what_the_criterion_says(gamma, expected):
    """A circulant matrix is normal: motors that are all coupled alike."""
    strong, weak = SERVO, SERVO * 0.3
    T = SystemMatrix(((strong, weak, weak), (weak, strong, weak), (weak, weak, strong)))
    found, singular = eigenloci(T, gamma, 2, LOW), heuristic_criterion(T, gamma, 2, LOW)
    assert found.spectral_radius == pytest.approx(singular.contraction, rel=AGREED)
    assert found.is_met == singular.is_met == expected


def test_a_coupling_one_way_leaves_the_loci_and_makes_the_error_grow_before_it_falls():
    zero = SERVO * 0.0
    coupled = SystemMatrix(((SERVO, SERVO * 8.0), (zero, SERVO)))
    alone = eigenloci(SERVO, 0.9, 2, LOW)
    found = eigenloci(coupled, 0.9, 2, LOW)
    assert found.spectral_radius == pytest.approx(alone.spectral_radius, rel=1e-4)
    assert alone.is_met
    singular = heuristic_criterion(coupled, 0.9, 2, LOW).contraction
    assert singular > 3.0 * found.spectral_radius
    at = np.array([found.limiting_omega])
    A = dense_iteration(coupled, 0.9, 2, LOW, at)[0]
    growth = [np.linalg.norm(np.linalg.matrix_power(A, k), 2) for k in (1, 60)]
    assert growth[0] > 1.0
    assert growth[1] < 1e-3


def test_motors_without_coupling_keep_one_smooth_locus_each():
    """Their curves cross in the plane: columns follow the motor, not the modulus."""
    slower = System(np.array([0.02]), np.array([1.0, -0.98]), T_S)
    found = eigenloci(SystemMatrix.diagonal([SERVO, slower]), 0.9, 0, ALL_PASS)
    curves = np.stack([1.0 - 0.9 * s.response(found.omega) for s in (SERVO, slower)], axis=1)
    order = [0, 1] if abs(found.values[-1, 0] - curves[-1, 0]) < 1e-9 else [1, 0]
    np.testing.assert_allclose(found.values[:, order], curves, atol=1e-12)


def test_a_filter_without_known_poles_gives_loci_without_a_bound():
    class Half:
        def __call__(self, signal, /):
            return 0.5 * signal

        def response(self, omega):
            return np.full(np.shape(omega), 0.5)

        def check(self, n_samples, n_columns):
            pass

    found = eigenloci(SystemMatrix.diagonal([SERVO, SERVO]), 0.9, 2, Half())
    assert found.bound is None
    assert found.is_met == (found.spectral_radius < 1.0)


@pytest.mark.parametrize("size", [1, 3, 4])
def test_a_map_has_its_largest_singular_value_however_small_it_is(size):
    scale = -np.arange(1.0, size + 1.0)[:, None]
    times = SimpleNamespace(
        n_inputs=1, n_outputs=1, simulate=lambda u: scale * u, adjoint=lambda e: scale * e
    )
    assert largest_singular_value(times, size) == pytest.approx(size, rel=1e-9)
