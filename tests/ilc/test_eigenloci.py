"""Loci of coupled motors: eigenvalues, their bound, and what they say of convergence."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.analysis import eigenloci, heuristic_criterion
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix

from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, entries_of, random_matrix
from .test_dense_analysis import narrow_grid

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


def test_an_unstable_plant_is_refused():
    with pytest.raises(ValueError, match="T_u"):
        eigenloci(System(np.array([1.0]), np.array([1.0, -1.1]), T_S), 0.9, 0, LOW)
