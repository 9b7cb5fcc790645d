"""A segment of a record that has converged keeps its correction while the others learn on."""

import numpy as np

from armside.ilc.filters import ALL_PASS
from armside.ilc.laws import Heuristic, Law
from armside.ilc.laws.wrappers import BySegment
from armside.ilc.learning import learn
from armside.ilc.measures.norms import two_norm

N, HALF = 200, 100
WEIGHT = np.repeat(np.eye(2), HALF, axis=0)
LAW = BySegment(
    law=Heuristic(Q=ALL_PASS, gamma=0.5, delta=0),
    weight=WEIGHT,
    judged=((0, HALF), (HALF, N)),
    size_of=two_norm,
    least=0.2,
)


class Plant:
    """The second half follows its input; the first is off by what no input changes."""

    def run(self, correction):
        y = correction.copy()
        y[:HALF] = 0.1 * y[:HALF] / (1.0 + np.abs(y[:HALF]))
        return y


def trials(law: Law = LAW, count=8):
    return list(learn(Plant(), law, np.ones((N, 1)), count))


def test_a_loop_that_is_resumed_holds_what_was_held():
    whole = trials()
    again = list(learn(Plant(), LAW, np.ones((N, 1)), 3, resume=whole[5].state))
    for trial, same in zip(again, whole[6:], strict=False):
        np.testing.assert_array_equal(trial.correction, same.correction)
