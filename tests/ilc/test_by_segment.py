"""A contour of a part that has converged keeps its correction while the others learn on."""

import numpy as np
import pytest
from armside.sim.part_run.learning import learn as learn_part

from armside.ilc.filters import ALL_PASS
from armside.ilc.laws import Heuristic, Law
from armside.ilc.laws.wrappers import BySegment
from armside.ilc.learning import learn
from armside.ilc.measures.norms import two_norm
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.part_cut import Job, prepare, weights
from armside.sim.laser.specification import Setup
from armside.sim.part.chain import arc, line
from armside.sim.part.drawing import Joined
from armside.sim.part.part import part_of
from armside.sim.part.plan import Cutting

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


def test_a_segment_that_no_longer_improves_keeps_its_best_correction():
    found = trials()
    held = [None if t.memory is None else t.memory.held.tolist() for t in found]
    since = next(k for k, each in enumerate(held) if each and each[0])
    assert since >= 3, "two updates running have to bring little"
    sizes = [np.linalg.norm(t.error[:HALF]) for t in found]
    for trial in found[since:]:
        assert trial.memory.held.tolist() == [True, False]
        best = found[int(np.argmin(sizes[:since]))].correction[:HALF]
        np.testing.assert_array_equal(trial.correction[:HALF], best)
    free = trials(LAW.law)
    for trial, alone in zip(found, free, strict=True):
        np.testing.assert_allclose(trial.correction[HALF:], alone.correction[HALF:])


def test_a_loop_that_is_resumed_holds_what_was_held():
    whole = trials()
    again = list(learn(Plant(), LAW, np.ones((N, 1)), 3, resume=whole[5].state))
    for trial, same in zip(again, whole[6:], strict=False):
        np.testing.assert_array_equal(trial.correction, same.correction)


@pytest.fixture(scope="module")
def experiment():
    plate = line((0.1, 0.2), (0.14, 0.2), (0.14, 0.23), (0.1, 0.23), (0.1, 0.2))
    hole = arc((0.11, 0.21), 0.005, 0.0, 2.0 * np.pi)
    part = part_of([Joined(plate, ("plate",), ""), Joined(hole, ("hole",), "")])
    return prepare(Job(part=part, cutting=Cutting(speed=0.06, rapid=0.2), setup=Setup(pose="p2")))


def test_corrections_of_contours_change_over_while_the_tool_rests(experiment):
    motion = experiment.motion
    share = weights(motion)
    np.testing.assert_allclose(share.sum(axis=1), 1.0)
    blending = ((share > 0.0) & (share < 1.0)).any(axis=1)
    assert blending.sum() > 20
    assert np.ptp(motion.position[blending], axis=0).max() < 1e-9
    for i, place in enumerate(motion.places):
        assert (share[motion.time >= place.contour_time[0], i][:1] == 1.0).all()


def test_learning_ends_when_all_contours_have_converged(experiment):
    set_up = MotorAngles().prepare(experiment)
    found = list(learn_part(experiment, set_up, 12, converged=0.5))
    assert found[-1].converged == (True, True)
    assert not all(found[-2].converged)
    assert len(found) < 12
    before, after = (np.linalg.norm(found[i].motor_error) for i in (0, -1))
    assert after < 0.5 * before
