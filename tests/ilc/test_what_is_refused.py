"""Arguments that gave infinities, NaN, numpy's messages or a broadcast: refused with their name."""

import control
import numpy as np
import pytest

from armside.ilc.analysis.criterion import asymptotic_error, criterion, heuristic_criterion
from armside.ilc.analysis.eigenloci import eigenloci
from armside.ilc.analysis.limits import largest_cutoff, largest_gamma
from armside.ilc.analysis.proposal import design_for, propose
from armside.ilc.analysis.robustness import contraction_map
from armside.ilc.dual_stage import DualStage
from armside.ilc.filters import AllPass, Edge, ZeroPhaseButterworth, shift
from armside.ilc.identification.arx import fit_arx
from armside.ilc.identification.first_order_lag import (
    LearningRecord,
    fit_first_order,
    learning_data,
)
from armside.ilc.identification.friction import friction
from armside.ilc.identification.impulse_response import Sums, impulse_response
from armside.ilc.laws.first_order import Blend, DType, FirstOrder, MatrixGain, PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.knob_free import KnobFree
from armside.ilc.laws.memory import (
    Adaptive,
    FrequencyKalman,
    HighOrder,
    internal_model,
    periodic_pattern,
)
from armside.ilc.laws.model_based import Gradient, ModelInverse
from armside.ilc.laws.model_free import FiniteDifference, MeasuredGradient, b_splines
from armside.ilc.laws.norm_optimal import Constrained, NormOptimal, PointToPoint
from armside.ilc.laws.quadratic import QuadraticCriterion
from armside.ilc.laws.repetitive import Repetitive
from armside.ilc.laws.robust import h_infinity
from armside.ilc.laws.transfer import derivatives
from armside.ilc.laws.wrappers import JointSpace, Scheduled
from armside.ilc.learning import learn
from armside.ilc.measures.iso9283 import crossings, path_accuracy, path_repeatability
from armside.ilc.measures.norms import fit_circle, normalise
from armside.ilc.models.conversion import as_state_space, as_system
from armside.ilc.models.linear_plant import LinearPlant
from armside.ilc.models.state_space import StateSpace, TimeVarying
from armside.ilc.models.system import System, tustin, zoh
from armside.ilc.models.system_matrix import SystemMatrix
from armside.ilc.models.two_mass import (
    FrictionPlant,
    PdController,
    TwoMassJoint,
    TwoMassLoop,
    TwoMassPlant,
    step_reference,
)
from armside.kinematics import CoupledRange

T = System(np.array([0.0, 0.5]), np.array([1.0, -0.5]), 0.004)
FINE = ZeroPhaseButterworth(10.0, 0.001)
RECORD = np.sin(0.1 * np.arange(50))[:, None]
TRUE = np.array([True, False])
W = np.array([0.1, 0.2])
nan = np.nan


class Wide:
    """A filter that returns two columns for one."""

    def __call__(self, signal):
        return np.hstack((signal, signal))


REFUSED = {
    "Q of 1 ms, model of 4 ms": (
        lambda: heuristic_criterion(T, 0.5, 1, FINE),
        "ZeroPhaseButterworth must have the sample time 0.004 s of T_u, got 0.001 s",
    ),
    "loci": (lambda: eigenloci(T, 0.5, 1, FINE), "sample time 0.004 s of T_u, got 0.001"),
    "limit": (lambda: asymptotic_error(RECORD, T, PType(), FINE), "of T_u, got 0.001 s"),
    "zoh, den 0": (lambda: zoh([1.0], [0.0, 0.0], 0.01), "den must have a coefficient that is not"),
    "states of continuous time": (
        lambda: as_state_space(control.ss([[-1.0]], [[1.0]], [[1.0]], 0.0)),
        "a model in continuous time needs a sample_time",
    ),
    "zoh, Ts 0": (lambda: zoh([1.0], [1.0, 1.0], 0.0), "sample_time must be > 0, got 0"),
    "zoh, no num": (lambda: zoh([], [1.0], 0.1), "num must be finite coefficients of shape"),
    "tustin, Ts 0": (lambda: tustin([1.0], [1.0, 1.0], 0.0), "sample_time must be > 0, got 0"),
    "tustin, den 0": (lambda: tustin([1.0], [0.0], 0.1), "den must have a coefficient"),
    "tustin, nan": (lambda: tustin([nan], [1.0], 0.1), "num must be finite coefficients"),
    "propose, no shift": (lambda: propose(T, 10.0, deltas=range(0)), "deltas must hold at least"),
    "propose, []": (lambda: propose(T, np.array([])), "bandwidth must be one finite number, got"),
    "propose, nan": (lambda: propose(T, nan), "bandwidth must be one finite number, got nan"),
    "design, no cutoff": (lambda: design_for(T, ()), "cutoffs must hold at least one"),
    "criterion, []": (lambda: criterion([], [], [], []), "omega must be finite, of shape"),
    "criterion, T_u": (lambda: criterion([1.0], 1.0, 1.0, W), "T_u must have 2 rows as omega"),
    "criterion, L": (lambda: criterion(W, [nan, 1], 1.0, W), "L must be finite numbers"),
    "criterion, 2-D": (lambda: criterion(np.ones((2, 2)), 1.0, 1.0, W), "T_u must have shape"),
    "gamma, nan": (lambda: largest_gamma(T, nan, None), "deltas must be a whole number"),
    "gamma, []": (lambda: largest_gamma(T, [], None), "deltas must have shape"),
    "gamma, no cutoff": (lambda: largest_gamma(T, 1, []), "cutoffs must have shape"),
    "cutoff, gain": (lambda: largest_cutoff(T, nan, 1), "gamma must be one finite number, got nan"),
    "cutoff, shift": (lambda: largest_cutoff(T, 0.5, nan), "delta must be a whole number"),
    "derivative, Ts 0": (lambda: derivatives(RECORD, 0.0), "sample_time must be > 0, got 0"),
    "derivative 500": (lambda: derivatives(RECORD, 0.004, 500), "order must be 1 to 10, got 500"),
    "derivative of one": (lambda: derivatives(RECORD[:1], 0.004), "at least 2 samples, got 1"),
    "range, nan": (
        lambda: CoupledRange(coefficients=(1.0, 1.0), lower=nan, upper=1.0),
        "lower below upper, got nan and 1",
    ),
    "range, 0": (
        lambda: CoupledRange(coefficients=(0.0,), lower=0.0, upper=1.0),
        "finite coefficients that are not",
    ),
    "iso": (
        lambda: path_accuracy(np.zeros((1, 3)), np.zeros((2, 5, 3))),
        r"each run of attained must have the shape \(1, 3\) as commanded, got \(5, 3\)",
    ),
    "iso, planes": (
        lambda: crossings(np.zeros((4, 2)), np.ones((4, 2)), np.zeros((9, 3))),
        "attained and commanded must have one dimension, got 3 and 2",
    ),
    "heuristic, filter": (
        lambda: Heuristic(Q=Wide())(RECORD, RECORD),
        r"Q must return the shape \(50, 1\), got \(50, 2\)",
    ),
    "heuristic, gains": (
        lambda: Heuristic(Q=AllPass(), gamma=(0.5, 0.5))(RECORD, RECORD),
        "gamma must be one value or one for each of 1, got 2",
    ),
    "truth values as a record": (lambda: T.simulate(TRUE[:, None]), "real numbers, got bool"),
    "truth values as b": (lambda: System(TRUE, W, 0.1), "b must be real numbers, got bool"),
    "truth values as A": (
        lambda: StateSpace(TRUE[:1, None], TRUE[:1, None], TRUE[:1, None]),
        "A must be real numbers, got bool",
    ),
    "truth values as gains": (lambda: MatrixGain(gamma=np.eye(2) > 0), "gamma must be real"),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_with_name_and_value_and_without_a_warning(name):
    call, said = REFUSED[name]
    with pytest.raises(ValueError, match=said):
        call()


WIDE = StateSpace(np.diag([0.5, 0.3]), np.ones((2, 3)), np.eye(2), None, 0.004)
TWO = ZeroPhaseButterworth((5.0, 20.0), 0.004)
NEED_SQUARE = heuristic_criterion, eigenloci
NEED_RESPONSE = (
    lambda T: heuristic_criterion(T, 0.5, 1, FINE),
    lambda T: eigenloci(T, 0.5, 1, FINE),
    lambda T: asymptotic_error(RECORD, T, PType(), FINE),
    lambda T: ModelInverse(T_u=T, learned=FINE),
    lambda T: h_infinity(T, FINE),
)
N, ONES = 90, np.ones((50, 1))
MATRIX = SystemMatrix.diagonal([T, T])
LOW = ZeroPhaseButterworth(20.0, 0.004)
UNSTABLE = System([0, 1], [1, -1.1], 0.01)
NOTHING = System([0.0], [1.0], 0.01)
FIVE = QuadraticCriterion(error=np.ones(5), change=1)
FADING = FirstOrder(L=Blend(filters=(PType(),), weights=np.ones((90, 1))))
ALONG = TimeVarying(
    *(np.repeat(M[None], 40, axis=0) for M in (0.5 * np.eye(2),) + (np.eye(2),) * 2)
)
SQUARE = np.array([[0.5]]), np.ones((1, 2)), np.ones((1, 1))
LAW = FirstOrder(L=PType(gamma=0.5, delta=1))
ROWS = [
    # models and plants
    (lambda: SystemMatrix(((T,), (T, T))), "square matrix"),
    (lambda: System.from_z([1, 0, 0], [1, 0.5], 0.01), "numerator degree 2 in q"),
    (lambda: System([1], [0, 1], 0.01), "not causal"),
    (lambda: T * System([1], [1], 0.008), "have one sample time"),
    (lambda: as_system("G"), "model must be a System"),
    (lambda: StateSpace(SQUARE[0], SQUARE[1].T, SQUARE[2]), r"each other: .* needed are \(n, n\)"),
    (lambda: StateSpace(*SQUARE).simulate(np.ones((9, 1))), "T_u has 2 inputs, the record 1"),
    (lambda: LinearPlant(T_u=T, reference=ONES, noise=1.0), "needs an rng"),
    (
        lambda: LinearPlant(T_u=T, reference=ONES, loads=(ONES[:4],)),
        r"loads must have shape \(50, 1",
    ),
    (lambda: LinearPlant(T_u=UNSTABLE, reference=ONES), "T_u is unstable"),
    (lambda: LinearPlant(T_u=object(), reference=ONES), "T_u must be a model with"),
    (
        lambda: LinearPlant(T_u=MATRIX, reference=np.ones((50, 2)), C=T),
        "needs a T_u with one input",
    ),
    (
        lambda: LinearPlant(T_u=ALONG, reference=np.ones((50, 2))).run(0.0),
        "correction must have shape",
    ),
    (
        lambda: LinearPlant(T_u=T, reference=ONES, C=System([9.0], [1.0], 0.004)),
        "direct term C is un",
    ),
    (lambda: ALONG.simulate(np.ones((50, 2))), "T_u covers 40 samples, the record 50"),
    (
        lambda: TwoMassPlant(loop=TwoMassLoop(controller=PdController(Kp=600.0))),
        "closed loop is unst",
    ),
    (lambda: TwoMassJoint(k=0.0), "k must be > 0"),
    (lambda: TwoMassJoint(Ja=-1.0), "Ja must be > 0"),
    (lambda: TwoMassJoint(d=-0.1), "d must be"),
    (lambda: step_reference(150), "within the record of 150 samples"),
    (lambda: FrictionPlant(coulomb=-1.0), "coulomb must be"),
    (lambda: FrictionPlant(noise=1.0), "needs an rng"),
    (lambda: FrictionPlant(substeps=0), "substeps"),
    (lambda: DualStage(torque="both"), "torque must be None, motor or load, got 'both'"),
    # filters and shifts
    *(
        (lambda f=f: ZeroPhaseButterworth(f, 0.004), r"cutoff .* Nyquist frequency 125 Hz")
        for f in (0.0, -1.0, 125.0, 200.0, nan, np.inf, (10.0, 125.0))
    ),
    (
        lambda: ZeroPhaseButterworth((1.0, 2.0), 0.004)(np.zeros((100, 6))),
        "one for each of 6, got 2",
    ),
    (lambda: ZeroPhaseButterworth(1.0, 0.004)(np.zeros((6, 1))), "longer than the pad of 6"),
    (lambda: ZeroPhaseButterworth(1.0, 0.004, order=5), "order must be"),
    (lambda: ZeroPhaseButterworth(1.0, nan), "sample_time"),
    (
        lambda: ZeroPhaseButterworth(1e-5, 0.004, edge=Edge.REST)(ONES),
        r"rings for .* with Edge.REST",
    ),
    *((lambda d=d: shift(np.zeros((4, 2)), d), "record of 4 samples") for d in (4, -4, 99, (0, 4))),
    # laws
    (lambda: DType(gamma_d=nan, sample_time=0.01), "gamma_d must be finite"),
    (lambda: MatrixGain(gamma=np.ones((2, 3))), r"finite \(n, n\) matrix"),
    (lambda: HighOrder(alpha=(1,), beta=(1, 2), L=PType()), "equally many"),
    (lambda: internal_model((1.0,), L=PType()), r"pattern must be \(1, d_1"),
    (lambda: internal_model((1, 0, -1), L=PType(), pole=1.0), "pole must be in"),
    (lambda: periodic_pattern(0), "period must be >= 1"),
    (lambda: Adaptive(L=PType(), noise_variance=0, initial_variance=1), "noise_variance"),
    (lambda: Scheduled(laws=()), "at least one law"),
    (lambda: Blend(filters=(PType(),), weights=np.ones((5, 2))), r"shape \(N, 1\)"),
    *(
        (lambda s=s: MeasuredGradient(experiment=len, size=s), f"size must be > 0, got {s}")
        for s in (0.0, -1.0, nan, np.inf)
    ),
    (lambda: FiniteDifference(experiment=len, basis=ONES, size=0.0), "size must be > 0"),
    (lambda: b_splines(10, 3), r"n_basis must be in 4\.\.10"),
    (lambda: FADING.check(60, 1), "weights cover 90 samples, the record 60"),
    (lambda: JointSpace(law=FADING, inverse=np.ones((2, 3))).check(1, 6), "2 motors"),
    (lambda: QuadraticCriterion(correction=0, change=0), "must not both be 0"),
    (lambda: QuadraticCriterion(correction=-1.0), "weight of the correction must be >= 0"),
    (lambda: NormOptimal(T_u=T, n_samples=N, criterion=FIVE), r"error must be a number, \(90,\)"),
    (lambda: NormOptimal(T_u=UNSTABLE, n_samples=N), "T_u is unstable"),
    (lambda: NormOptimal(T_u=StateSpace(2.5 * SQUARE[0], *SQUARE[1:]), n_samples=N), "unstable"),
    (lambda: NormOptimal(T_u=ALONG, n_samples=50), "T_u covers 40 samples, the record 50"),
    (lambda: NormOptimal(T_u=object(), n_samples=50), "n_inputs, n_outputs, simulate and adjoint"),
    (lambda: Constrained(T_u=T, n_samples=N, limit=0.0), "limit must be > 0"),
    (lambda: Constrained(T_u=T, n_samples=N, limit=np.ones(7)), "limit must be a number"),
    (lambda: PointToPoint(T_u=T, points=[90], n_samples=90), "must be samples 0 to 89"),
    (lambda: h_infinity(T, LOW, n_taps=5, lead=5), "lead must be in 0"),
    (lambda: h_infinity(T, LOW, uncertainty=-1.0), "uncertainty must be >= 0"),
    (lambda: FrequencyKalman(L=PType(), noise=0.0), "noise must be > 0"),
    (lambda: Repetitive(L=PType(), period=1), "period and begin"),
    (lambda: Repetitive(L=PType(), period=100).check(150, 1), "two laps of 100"),
    *(
        (lambda g=g: Heuristic(Q=LOW, gamma=g), "gamma must be > 0")
        for g in (0, -0.5, nan, (0.9, -1))
    ),
    *((lambda d=d: Heuristic(Q=LOW, delta=d), "whole number of samples") for d in (1.5, nan)),
    (lambda: Gradient(T_u=NOTHING), "T_u is 0"),
    (lambda: h_infinity(NOTHING, LOW), "T_u is 0"),
    (lambda: ModelInverse(T_u=NOTHING, learned=LOW), "T_u is 0"),
    (lambda: ModelInverse(T_u=UNSTABLE, learned=LOW), "T_u is unstable"),
    (lambda: ModelInverse(T_u=T, learned=LOW, rate=2.0), r"rate must be in \(0, 2\)"),
    (lambda: ModelInverse(T_u=MATRIX, learned=LOW).check(50, 3), "T_u has 2 inputs, the record 3"),
    (
        lambda: KnobFree(Q=LOW, reference=ONES).check(200, 2),
        r"reference has shape \(50, 1\), the rec",
    ),
    # analysis
    (lambda: largest_gamma(UNSTABLE, [1], [5.0]), r"T_u is unstable: .* pole has modulus 1\.1"),
    (lambda: eigenloci(UNSTABLE, 0.5, 1, LOW), "T_u is unstable"),
    (lambda: propose(UNSTABLE, 5.0), "T_u is unstable"),
    (lambda: propose(T * -1.0, 5.0), "static gain of T_u must be > 0"),
    (lambda: propose(T, 125.0), "below the Nyquist frequency 125 Hz"),
    *((lambda f=f: f(ALONG), "time-invariant") for f in NEED_RESPONSE),
    *((lambda f=f: f(WIDE, 0.5, 1, LOW), "as many outputs as inputs") for f in NEED_SQUARE),
    *((lambda f=f: f(T, 0.5, 1, TWO), "several cutoffs") for f in NEED_SQUARE),
    (lambda: h_infinity(WIDE, LOW), "one input and one output, got 3 and 2"),
    (lambda: asymptotic_error(RECORD, T, PType(gamma=0.5), TWO), "2 cutoffs, the error 1 columns"),
    (
        lambda: contraction_map(
            TwoMassLoop(), Heuristic(Q=LOW), ("stiffness", [1.0]), ("k", [1.0])
        ),
        r"Unknown parameter 'stiffness'\. Parameters: k, d, Ja",
    ),
    # identification and measures
    (lambda: fit_arx(ONES, ONES, 0.01, na=-1, nb=1, nk=5), "orders must be"),
    (lambda: fit_arx(ONES, ONES, 0.01, na=1, nb=1, nk=5000), "need more than"),
    (lambda: fit_arx(ONES, ONES, 0.01, na=1, nb=1, nk=5, skip=2), "need more than"),
    (lambda: fit_arx(ONES, ONES, 0.01, na=1, nb=1, nk=1), "do not excite 2 coefficients"),
    (lambda: fit_arx(ONES, np.ones((50, 2)), 0.01, na=1, nb=1, nk=1), "one shape"),
    (lambda: fit_first_order(ONES, ONES[1:], 0.01), "one shape"),
    (lambda: fit_first_order(0.0 * ONES, ONES, 0.01), "zero throughout"),
    (lambda: fit_first_order(ONES, ONES, 0.01, delays=[]), "delays must not be empty"),
    (lambda: learning_data([]), "at least one record"),
    (lambda: learning_data([LearningRecord(ONES, ONES, ONES, 0)]), "must be >= 1 sample, got 0"),
    (lambda: impulse_response(Sums.none(5).with_records(0.0 * ONES, ONES)), "output are not zero"),
    *(
        (lambda r=r: friction(ONES, r), r"shape \(50, 1\), one or more")
        for r in ([], [(ONES, ONES[1:])])
    ),
    *(
        (lambda x=x: friction(ONES, [(x, ONES)]), "must be|must have")
        for x in (nan * ONES, ONES[:, 0])
    ),
    (lambda: normalise(1.0, [0.0, 0.0]), "largest error without learning"),
    (lambda: fit_circle(np.zeros((2, 3))), "M >= 3"),
    (lambda: fit_circle(np.outer(np.arange(5.0), [1, 2, 3])), "one line"),
    (lambda: fit_circle(1.7 + np.outer(np.linspace(0.0, 0.3, 99), [0.1, 0.7, 0.3])), "one line"),
    (lambda: fit_circle(np.full((5, 3), nan)), "5 of 5 are not"),
    (lambda: path_repeatability(np.zeros((1, 3, 2))), "two runs or more, got 1"),
    (lambda: path_accuracy(np.zeros((3, 2)), np.zeros((3, 2))), "shape"),
]


@pytest.mark.parametrize(("build", "said"), ROWS)
def test_invalid_design_variables_are_refused_by_name(build, said):
    with pytest.raises(ValueError, match=said):
        build()


class Greedy:
    """A plant that writes into what it is given."""

    def run(self, correction):
        output = T.simulate(correction)
        correction[:] = 7.0
        return output


def test_a_plant_that_writes_into_its_correction_does_not_change_the_record():
    class Plain:
        run = staticmethod(T.simulate)

    found, wanted = (list(learn(plant, LAW, RECORD, 3)) for plant in (Greedy(), Plain()))
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one.correction, other.correction)
    first = np.zeros_like(RECORD)
    list(learn(Greedy(), LAW, RECORD, 0, first_correction=first))
    assert not first.any()


def test_a_plant_that_returns_nan_before_any_learning_is_an_error():
    class Broken:
        def __init__(self, from_run):
            self.from_run = from_run

        def run(self, correction):
            self.from_run -= 1
            return T.simulate(correction) + (nan if self.from_run < 0 else 0.0)

    with pytest.raises(ValueError, match="the output of run 0 must be finite, got nan at sample 0"):
        list(learn(Broken(0), LAW, RECORD, 3))
    assert [trial.diverged for trial in learn(Broken(1), LAW, RECORD, 3)] == [False, True]
