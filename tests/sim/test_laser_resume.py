"""A learning loop goes on from its state on disk, the memory of its law included."""

import numpy as np
import pytest

from armside.ilc.workbench.compare import read_states, save_states
from armside.sim.laser import Cut, prepare
from armside.sim.laser.learning import iterate
from armside.sim.laser.resume import state_after
from armside.sim.laser.tool_measure import Source, ToolPath
from armside.sim.part.carried import carried, follows
from armside.sim.records.files import InputError

CUT = Cut(radius=0.003, speed=0.060)
MEASURE = ToolPath(source=Source.TRACKER)
"""Without an IMU, on assumed springs: a law with a guard, which remembers its best iteration."""


def iterations(count, start=None, resume=None, seed=0):
    experiment = prepare(CUT, seed=seed)
    set_up = MEASURE.prepare(experiment)
    found = []
    for iteration in iterate(experiment, set_up, count, start=start, resume=resume):
        found.append(iteration)
    begun = start if resume is None else resume.start
    return found, state_after(found[-1].state, experiment.plant, begun)


@pytest.mark.parametrize("centre", [None, 1e-5])
def test_a_guarded_law_goes_on_to_the_last_bit(centre, tmp_path):
    shape = prepare(CUT).loaded.reference.shape
    start = None if centre is None else np.full(shape, centre)
    whole, _ = iterations(3, start)
    _, state = iterations(1, start)
    save_states(tmp_path / "state.npz", {"a": state})
    again, _ = iterations(2, resume=read_states(tmp_path / "state.npz")["a"])
    assert [one.k for one in again] == [0, 2, 3]
    for k, one in zip((0, 2, 3), again, strict=True):
        np.testing.assert_array_equal(one.correction, whole[k].correction)
        np.testing.assert_array_equal(one.run.tracker.position, whole[k].run.tracker.position)


def test_the_state_of_another_robot_is_refused():
    _, state = iterations(0)
    with pytest.raises(InputError, match="does not come out the same here"):
        iterations(1, resume=state, seed=1)


def test_a_correction_keeps_its_place_on_the_path_at_another_speed():
    slow, fast = (prepare(Cut(speed=v)).motion for v in (0.02, 0.06))
    at = slow.position - slow.position[0]
    found = carried(np.hstack([at, at]), slow, fast)
    on = fast.on_contour
    np.testing.assert_allclose(
        found[on, :2] + slow.position[0, :2], fast.position[on, :2], atol=1e-5
    )
    assert not follows(slow, prepare(Cut(pose="p2")).motion)
    assert not follows(slow, prepare(Cut(radius=0.006)).motion)
    with pytest.raises(ValueError, match="belongs to its path"):
        carried(np.hstack([at, at]), slow, prepare(Cut(radius=0.006)).motion)
