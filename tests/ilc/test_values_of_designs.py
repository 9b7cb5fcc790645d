"""Design values that were once cut to something else without a word."""

import numpy as np
import pytest

from armside.ilc.analysis.criterion import asymptotic_error, heuristic_criterion
from armside.ilc.filters import ALL_PASS, ZeroPhaseButterworth, shift
from armside.ilc.laws.first_order import Blend, DType, MatrixGain, PType
from armside.ilc.laws.model_based import Beyond, Gradient, ModelInverse
from armside.ilc.laws.model_free import FiniteDifference
from armside.ilc.laws.norm_optimal import Constrained, PointToPoint
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.repetitive import PlugIn, Repetitive
from armside.ilc.laws.robust import h_infinity
from armside.ilc.laws.transfer import BasisFunctions, RationalBasis
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System, tustin, zoh

N, T_S = 30, 0.01
SERVO = System([0.0, 0.5], [1.0, -0.5], T_S)
NOTHING = System([0.0], [1.0], T_S)
LOW = ZeroPhaseButterworth(10.0, T_S)
COMPLEX = np.array([1.0 + 1.0j, 1.0])


@pytest.mark.parametrize(
    "build",
    [
        lambda: System(COMPLEX, [1.0], T_S),
        lambda: System([1.0], COMPLEX, T_S),
        lambda: System.from_z([1.0], COMPLEX, T_S),
        lambda: zoh([1.0], COMPLEX, T_S),
        lambda: tustin([1.0], COMPLEX, T_S),
        lambda: MatrixGain(gamma=COMPLEX * np.eye(2)),
        lambda: Blend(filters=(ALL_PASS,), weights=np.full((N, 1), 1j)),
        lambda: FiniteDifference(experiment=len, basis=np.full((N, 1), 1j)),
        lambda: QuadraticCriterion(error=COMPLEX, change=1.0),
        lambda: QuadraticCriterion(change=1.0, error_filter=COMPLEX),
        lambda: Constrained(T_u=SERVO, n_samples=2, limit=COMPLEX),
        lambda: BasisFunctions(T_u=SERVO, basis=np.full((N, 1, 1), 1j)),
        lambda: RationalBasis(T_u=SERVO, reference=np.full((N, 1), 1j)),
    ],
)
def test_complex_values_are_refused_and_not_cut(build):
    with pytest.raises(ValueError, match="must be real numbers, got complex128"):
        build()


@pytest.mark.parametrize(
    "build",
    [
        lambda: shift(np.zeros((N, 1)), 1.5),
        lambda: PType(delta=1.5),
        lambda: DType(gamma_d=0.1, sample_time=T_S, delta=1.5),
        lambda: MatrixGain(gamma=np.eye(2), delta=(1, 1.5)),
        lambda: heuristic_criterion(SERVO, 0.5, 1.5, LOW),
        lambda: heuristic_criterion(SERVO, 0.5, np.nan, LOW),
        lambda: PointToPoint(T_u=SERVO, points=[1.7], n_samples=N),
        lambda: PointToPoint(T_u=SERVO, points=[np.nan], n_samples=N),
        lambda: PointToPoint(T_u=SERVO, points=np.arange(N) == 5, n_samples=N),
        lambda: Repetitive(L=PType(), period=10.5),
        lambda: Repetitive(L=PType(), period=np.nan),
        lambda: Repetitive(L=PType(), period=10, begin=0.5),
        lambda: PlugIn(T_u=SERVO, L=PType(), period=10.5),
    ],
)
def test_what_is_counted_in_samples_is_whole(build):
    with pytest.raises(ValueError, match="whole number of samples"):
        build()


def test_whole_numbers_of_any_type_are_samples():
    points = PointToPoint(T_u=SERVO, points=np.array([3.0, 5.0, 3.0, N - 1]), n_samples=N)
    known = PointToPoint(T_u=SERVO, points=[3, 5, N - 1], n_samples=N)
    e = np.ones((N, 1))
    assert np.array_equal(points(0.0 * e, e), known(0.0 * e, e))
    assert np.array_equal(PType(delta=np.float64(2.0))(e.cumsum(0)), PType(delta=2)(e.cumsum(0)))
    assert Repetitive(L=PType(), period=10.0, begin=2.0).laps(np.ones((10, 1)), N).shape == (N, 1)
    assert PlugIn(T_u=SERVO, L=PType(), period=10.0).run(np.ones((N, 1))).shape == (N, 1)


@pytest.mark.parametrize(
    "build",
    [
        lambda: Gradient(T_u=NOTHING),
        lambda: h_infinity(NOTHING, LOW),
        lambda: ModelInverse(T_u=NOTHING, learned=LOW),
    ],
)
def test_a_model_without_effect_is_refused(build):
    with pytest.raises(ValueError, match="T_u is 0"):
        build()


def test_an_inverse_where_the_model_is_zero_is_refused():
    washout = System([1.0, -1.0], [1.0, -0.5], T_S)
    for beyond in Beyond:
        law = ModelInverse(T_u=washout, learned=LOW, beyond=beyond)
        with pytest.raises(ValueError, match="regularisation"):
            law(np.ones((N, 1)))
    assert np.isfinite(
        ModelInverse(T_u=washout, learned=LOW, regularisation=1e-6)(np.ones((N, 1)))
    ).all()


@pytest.mark.parametrize("shape", [(2, 2), (3, 2), (2, 3)])
def test_an_inverse_of_nearly_equal_columns_is_that_of_its_singular_values(shape):
    """Coupling of condition 1e6: the normal equations lose twelve digits."""
    rng = np.random.default_rng(3)
    U, V = (np.linalg.qr(rng.standard_normal((n, n)))[0] for n in shape)
    D = U[:, :2] @ np.diag([1.0, 1e-6]) @ V[:, :2].T
    T = StateSpace(0.5 * np.eye(len(D)), D, np.eye(len(D)), sample_time=T_S)
    omega = np.array([0.1, 0.5])
    found = ModelInverse(T_u=T, learned=ALL_PASS).response(omega)
    for L, w in zip(found, omega, strict=True):
        wanted = (V[:, :2] @ np.diag([1.0, 1e6]) @ U[:, :2].T) * (np.exp(1j * w) - 0.5)
        np.testing.assert_allclose(L, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())


def test_an_inverse_of_equal_columns_is_refused():
    T = StateSpace([[0.5]], [[1.0, 1.0]], [[1.0], [1.0]], sample_time=T_S)
    with pytest.raises(ValueError, match="no inverse"):
        ModelInverse(T_u=T, learned=LOW)(np.ones((N, 2)))


def test_each_column_of_an_error_has_its_cutoff_or_all_have_one():
    Q = ZeroPhaseButterworth((5.0, 8.0), 0.01)
    e = np.ones((60, 2))
    both = asymptotic_error(e, SERVO, PType(gamma=0.5), Q)
    for column, cutoff in enumerate((5.0, 8.0)):
        alone = ZeroPhaseButterworth(cutoff, 0.01)
        wanted = asymptotic_error(e[:, :1], SERVO, PType(gamma=0.5), alone)
        np.testing.assert_allclose(both[:, [column]], wanted, rtol=1e-12)
    with pytest.raises(ValueError, match="Q has 2 cutoffs, the error 1 columns"):
        asymptotic_error(e[:, :1], SERVO, PType(gamma=0.5), Q)
