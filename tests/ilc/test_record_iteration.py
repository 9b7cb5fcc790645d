"""Matrix-free analysis of finite records beside dense matrices, and in time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.ilc.analysis.adjoint import filter_adjoint, law_adjoint
from armside.ilc.analysis.record_iteration import RecordIteration
from armside.ilc.filters import ALL_PASS, Edge, End, ZeroPhaseButterworth
from armside.ilc.laws import FirstOrder, Heuristic
from armside.ilc.laws.first_order import DType, MatrixGain, PType
from armside.ilc.laws.model_based import Gradient
from armside.ilc.laws.norm_optimal import NormOptimal
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.two_mass import TwoMassLoop

from .random_cases import AGREED, DAMPING, SEED, SLOWEST, T_S, cases, random_state_matrix


def random_plant(rng, n, order, slowest, damping):
    A = random_state_matrix(rng, order, slowest, damping)
    B, C = rng.standard_normal((order, n)), rng.standard_normal((n, order))
    gain = np.linalg.norm(C @ np.linalg.solve(np.eye(order) - A, B), 2)
    return StateSpace(A, B, C / gain, None, T_S)


def law_of(kind, T_u, n, n_samples, edge, end):
    cutoffs = tuple(np.linspace(10.0, 30.0, n).tolist())
    Q = ZeroPhaseButterworth(cutoffs, T_S, edge=edge)
    if kind == "heuristic":
        return Heuristic(Q=Q, gamma=tuple(np.linspace(0.3, 0.6, n)), delta=2, end=end)
    if kind == "matrix gain":
        gamma = 0.4 * np.eye(n) + 0.05
        return FirstOrder(L=MatrixGain(gamma=gamma, delta=3, end=end), Q=Q)
    if kind == "d-type":
        return FirstOrder(L=DType(gamma_d=0.01, sample_time=T_S, delta=2, end=end), Q=Q)
    if kind == "gradient":
        return FirstOrder(L=Gradient(T_u=T_u), Q=Q)
    criterion = QuadraticCriterion(correction=1e-3, change=1e-2, error_filter=(1.0, -0.5))
    return NormOptimal(T_u=T_u, n_samples=n_samples, criterion=criterion)


calls = []


class Counted(FirstOrder):
    def __call__(self, correction, error, /):
        calls.append(1)
        return super().__call__(correction, error)


def dense_map(function, shape):
    size = int(np.prod(shape))
    units = np.eye(size).reshape(size, *shape)
    return np.stack([function(unit).ravel() for unit in units], axis=1)


@cases(5)
@given(
    kind=st.sampled_from(["heuristic", "matrix gain", "d-type", "gradient", "norm-optimal"]),
    n=st.integers(1, 3),
    order=st.integers(1, 14),
    slowest=SLOWEST,
    damping=DAMPING,
    edge=st.sampled_from(list(Edge)),
    end=st.sampled_from(list(End)),
    seed=SEED,
)
def test_figures_of_an_iteration_are_those_of_its_matrix(
    kind, n, order, slowest, damping, edge, end, seed
):
    rng = np.random.default_rng(seed)
    n_samples = 50
    T_u = random_plant(rng, n, order, slowest, damping)
    law = law_of(kind, T_u, n, n_samples, edge, end)
    found = RecordIteration(T_u, law, n_samples, n)
    A = dense_map(lambda u: law(u, -T_u.simulate(u)), (n_samples, n))
    assert found.contraction == pytest.approx(np.linalg.norm(A, 2), rel=AGREED)
    cubed = np.linalg.norm(np.linalg.matrix_power(A, 3), 2)
    assert found.transient_growth(3)[0] == pytest.approx(cubed, rel=AGREED)
    radius = found.spectral_radius
    exact = np.abs(np.linalg.eigvals(A)).max()
    assert exact <= radius.bound * (1 + AGREED)
    if (
        radius.eigenvalue is not None and radius.residual is not None
    ):  # an eigenvalue of a matrix this close to A
        assert radius.residual <= AGREED * np.linalg.norm(A, 2)
        shifted = A.astype(complex) - radius.eigenvalue * np.eye(len(A))
        assert np.linalg.norm(shifted, -2) <= radius.residual + 1e-12 * np.linalg.norm(A, 2)


@pytest.mark.parametrize("end", End)
@pytest.mark.parametrize("edge", Edge)
def test_filters_and_their_adjoints_have_one_inner_product(edge, end):
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((2, 60, 2))
    for given_filter in (
        ZeroPhaseButterworth((5.0, 40.0), T_S, 3, edge),
        PType(gamma=0.7, delta=-4, end=end),
        DType(gamma_d=0.1, sample_time=T_S, delta=3, end=end),
        MatrixGain(gamma=np.array([[1.0, 0.3], [-0.2, 0.8]]), delta=(2, -1), end=end),
        ALL_PASS,
    ):
        left, right = np.vdot(given_filter(x), y), np.vdot(x, filter_adjoint(given_filter, y))
        assert left == pytest.approx(right, rel=1e-10)


def test_two_thousand_samples_take_fewer_products_than_their_matrix_has_columns():
    law = Counted(L=PType(gamma=0.9, delta=5), Q=ZeroPhaseButterworth(6.0, 0.01))
    iteration = RecordIteration(TwoMassLoop().T_motor, law, 2000)
    radius = iteration.spectral_radius
    assert radius.value is not None
    assert radius.value <= iteration.contraction * (1 + AGREED)
    assert len(calls) < 1000


def test_a_law_without_adjoint_is_refused_by_name():
    class Own:
        pass

    for adjoint in (filter_adjoint, law_adjoint):
        with pytest.raises(TypeError, match="Own has no adjoint"):
            adjoint(Own(), np.zeros((5, 1)))
