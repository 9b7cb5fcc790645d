"""Arguments that gave infinities, NaN, numpy's messages or a broadcast: refused with their name."""

import numpy as np
import pytest

from armside.ilc.analysis.criterion import asymptotic_error, criterion, heuristic_criterion
from armside.ilc.analysis.eigenloci import eigenloci
from armside.ilc.analysis.limits import largest_cutoff, largest_gamma
from armside.ilc.analysis.proposal import design_for, propose
from armside.ilc.filters import AllPass, ZeroPhaseButterworth
from armside.ilc.laws.first_order import FirstOrder, MatrixGain, PType
from armside.ilc.laws.heuristic import Heuristic
from armside.ilc.laws.transfer import derivatives
from armside.ilc.learning import learn
from armside.ilc.measures.iso9283 import crossings, path_accuracy
from armside.ilc.models.state_space import StateSpace
from armside.ilc.models.system import System, tustin, zoh
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


LAW = FirstOrder(L=PType(gamma=0.5, delta=1))


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
