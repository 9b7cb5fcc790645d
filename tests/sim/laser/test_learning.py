"""Learning a cut on the large robot: the story of thesis chapter 9, from Python."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from armside.ilc.laws.first_order import FirstOrderLaw
from armside.ilc.measures.norms import two_norm
from armside.ilc.workbench.compare import read_states, save_states
from armside.sim.cell import CELLS, LARGE_CELL
from armside.sim.evaluation.tool_error import tool_error
from armside.sim.laser import Cut, Design, MotorAngles, Pass, Source, ToolPath, learn, prepare
from armside.sim.laser.design import default_design
from armside.sim.laser.loop import MEASURES, first_run, iterate, measure_of
from armside.sim.laser.results import status
from armside.sim.part.motion import SAME, carried, follows
from armside.sim.records.files import InputError


@pytest.fixture(scope="module")
def first():
    """The run without correction, as an iteration."""
    (iteration,) = learn(Cut(), iterations=0)
    return iteration


def test_tracker_and_truth_agree_on_the_circle(first):
    assert first.tool.rms == pytest.approx(first.tool_true.rms, abs=2e-6)
    assert first.tool.maxdev == pytest.approx(first.tool_true.maxdev, abs=30e-6)  # noise of 785


def test_controller_knows_the_nominal_robot_only():
    """Individuals of other friction are asked for the same reference."""
    one, other = prepare(Cut(), seed=1), prepare(Cut(), seed=2)
    assert np.array_equal(one.loaded.reference, other.loaded.reference)
    friction = [e.loaded.model.mj.actuator_biasprm[:, 3] for e in (one, other)]
    assert not np.array_equal(*friction)


def test_a_turn_with_a_lost_beam_has_no_measure(first):
    seen = first.run.tracker
    position = seen.position.copy()
    position[len(position) // 2 :] = np.nan
    error = tool_error(prepare(Cut()).motion, seen.time, position)
    assert np.isnan(error.rms)
    assert np.isnan(error.maxdev)
    assert np.isfinite(error.path).all()


def test_circle_across_the_tool_is_perpendicular_to_its_axis():
    cut = Cut(across_tool=True)
    points = cut.path.position(np.linspace(0, cut.path.length, 50))
    centred = points - np.array(cut.tool_pose.position)
    assert np.abs(centred @ cut.tool_pose.tool_axis).max() < 1e-15


def test_a_bold_law_diverges_and_says_so():
    bold = MotorAngles(Design(gamma=(3.0,), delta=(3,), cutoff=(10.0,)))
    iterations = list(learn(Cut(), measure=bold, iterations=10))
    assert [it.diverged for it in iterations] == [False] * (len(iterations) - 1) + [True]
    assert len(iterations) < 11


def test_a_robot_learns_with_its_own_default_design():
    for name in CELLS:
        experiment = prepare(Cut(robot=name))
        output = MotorAngles().prepare(experiment)(first_run(experiment))
        assert output.law == default_design(CELLS[name]).law


class Returning(FirstOrderLaw):
    """Learns once and then returns to zero."""

    def __call__(self, correction, error, /):
        return 0.0 * correction if correction.any() else 1e-6 * np.ones_like(error)


@pytest.mark.parametrize("measure", ["motor", "tracker"])
def test_a_law_that_returns_to_zero_gets_a_run_of_its_own(measure):
    """The first run is known by its place, not by a correction of zero."""
    zero, _, again = learn(Cut(), measure=measure, law=Returning(), iterations=2)
    assert not zero.correction.any()
    assert not again.correction.any()
    assert again.run is not zero.run
    assert not np.array_equal(again.run.recording.motor_angle, zero.run.recording.motor_angle)


@dataclass(frozen=True)
class FirstMotors:
    """A measure of one's own: the first three motors; the others count as perfect."""

    imu = None

    def prepare(self, experiment):
        return lambda first: FirstMotorsOutput(experiment.loaded.reference)


@dataclass(frozen=True)
class FirstMotorsOutput:
    reference: np.ndarray
    law = default_design(LARGE_CELL).law

    def __call__(self, run):
        return np.hstack((run.recording.motor_angle[:, :3], self.reference[:, 3:]))

    def size(self, error):
        return two_norm(error)


def test_a_measure_of_ones_own_is_one_argument():
    before, after = learn(Cut(), measure=FirstMotors(), iterations=1)
    ratio = two_norm(after.motor_error) / two_norm(before.motor_error)
    assert (ratio[:3] < 0.6).all()
    assert (after.correction[:, 3:] == 0.0).all()


@dataclass
class Weakened:
    """A plant of one's own: half of the correction gets through."""

    plant: object
    runs: int = 0

    def run(self, correction, /) -> Pass:
        self.runs += 1
        return self.plant.run(0.5 * correction)


def test_a_plant_of_ones_own_is_one_argument():
    plant = Weakened(prepare(Cut()).plant)
    weak = list(learn(Cut(), plant=plant, iterations=1))
    full = list(learn(Cut(), iterations=1))
    assert plant.runs == 2
    assert np.array_equal(weak[1].correction, full[1].correction)
    assert (two_norm(weak[1].motor_error) > two_norm(full[1].motor_error)).all()


def test_a_cell_of_ones_own_is_a_robot():
    (mine,) = learn(Cut(robot=replace(LARGE_CELL, programs={})), iterations=0)
    (ours,) = learn(Cut(), iterations=0)
    assert mine.tool.rms == ours.tool.rms


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"cut": Cut(robot="small")}, "Unknown robot 'small'. Robots: large, irb1400"),
        ({"cut": Cut(pose="p9")}, r"Unknown pose 'p9'\. Poses: p1, p2, p3"),
        ({"cut": Cut(), "measure": "nose"}, "Unknown measure 'nose'. Measures: motor, estimate"),
        ({"cut": Cut(radius=5.0)}, "outside"),
    ],
)
def test_what_cannot_be_done_is_said_before_the_first_run(arguments, said):
    with pytest.raises(ValueError, match=said):
        learn(**arguments)


def test_measures_are_known_by_name():
    assert set(MEASURES) == {"motor", "estimate", "tracker", "scan", "truth"}
    experiment = prepare(Cut(imu=ToolPath().imu))
    reads = {name: measure_of(name).prepare(experiment) for name in ("motor", "truth")}
    motor = next(iterate(experiment, reads["motor"], 0))
    assert motor.error.shape == experiment.loaded.reference.shape


def test_an_iteration_learns_from_the_mean_of_its_runs():
    experiment = prepare(replace(Cut(), friction_spread=0.0))
    first = first_run(experiment)
    runs = []

    class Counted:
        def run(self, correction, /):
            runs.append(experiment.plant.run(correction))
            return runs[-1]

    set_up = MotorAngles().prepare(experiment)
    zero, one = iterate(experiment, set_up, 1, plant=Counted(), first=first, repeats=3)
    assert len(runs) == 2 + 3
    reference = experiment.loaded.reference
    angles = [run.recording.motor_angle for run in (first, *runs[:2])]
    assert zero.error == pytest.approx(reference - np.mean(angles, axis=0), abs=1e-15)
    angles = [run.recording.motor_angle for run in runs[2:]]
    assert one.error == pytest.approx(reference - np.mean(angles, axis=0), abs=1e-15)
    assert zero.run is first


CUT = Cut(radius=0.003, speed=0.060)
MEASURE = ToolPath(source=Source.TRACKER)
"""Without an IMU, on assumed springs: a law with a guard, which remembers its best iteration."""


def iterations(count, start=None, seed=0):
    experiment = prepare(CUT, seed=seed)
    return list(iterate(experiment, MEASURE.prepare(experiment), count, start=start))


@pytest.mark.parametrize("centre", [None, 1e-5])
def test_a_guarded_law_goes_on_to_the_last_bit(centre, tmp_path):
    shape = prepare(CUT).loaded.reference.shape
    start = None if centre is None else np.full(shape, centre)
    whole = iterations(3, start)
    save_states(tmp_path / "state.npz", {"a": iterations(1, start)[-1].state})
    again = iterations(2, read_states(tmp_path / "state.npz")["a"])
    assert [one.k for one in again] == [0, 2, 3]
    for k, one in zip((0, 2, 3), again, strict=True):
        np.testing.assert_array_equal(one.correction, whole[k].correction)
        np.testing.assert_array_equal(one.run.tracker.position, whole[k].run.tracker.position)


def test_the_state_of_another_robot_is_refused():
    (only,) = iterations(0)
    with pytest.raises(InputError, match="does not come out the same here"):
        iterations(1, only.state, seed=1)


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


@pytest.mark.parametrize(
    ("rms", "diverged", "of_tool", "end"),
    [
        ((1.0, 0.5), False, True, "done"),
        ((1.0, 2.0), False, True, "worse"),
        ((1.0, 2.0), False, False, "done"),  # its notes say so
        ((1.0, 0.5), True, True, "diverged"),
    ],
)
def test_a_run_that_learned_from_the_tool_and_made_it_worse_ends_so(rms, diverged, of_tool, end):
    recording = SimpleNamespace(limits_hit=(), reference=np.zeros((2, 6)))
    first, last = (
        SimpleNamespace(
            tool=SimpleNamespace(rms=r), diverged=False, run=SimpleNamespace(recording=recording)
        )
        for r in rms
    )
    last.diverged = diverged
    ended: Any = [first, last]
    assert status(ended, of_tool=of_tool) == end


LINE, SHORTER = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.array([[0.0, 0, 0]])


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ([LINE], False),
        ([LINE, LINE, LINE], False),
        ([LINE, SHORTER], False),
        ([LINE, LINE + 0.9 * SAME], True),
        ([LINE, LINE + 1.1 * SAME], False),
    ],
)
def test_contours_are_the_same_in_number_points_and_place(other, same):
    before, motion = (SimpleNamespace(outline=outline) for outline in ([LINE, LINE], other))
    assert follows(before, motion, anywhere=True) == same
