"""Verifications of twins by IMU: what is measured, and what their verdicts let pass."""

from types import SimpleNamespace

import numpy as np
import pytest

from armside.scripts.verifications import first_cut, first_cut_imu
from armside.scripts.verifications.imu_twin import BLOCKS, uncorrected, with_truth
from armside.sim.laser import Cut
from armside.sim.notes import Tally
from armside.sim.robot.individual import Individual
from armside.sim.robot.spread import Drawn

SAMPLED = 0.02
"""Left of a circle that is cancelled exactly: polygons of the log's samples stand for it."""


def _turned(gear: float, ripple: float) -> Individual:
    return Individual(gear_error_phase=np.full((6, 4), gear), ripple_phase=np.full(6, ripple))


@pytest.mark.parametrize(
    ("block", "gear", "ripple"),
    [("nothing", 0.3, 0.3), ("gear errors", 0.7, 0.3), ("torque ripple", 0.3, 0.5)],
)
def test_truth_of_a_block_turns_no_other(block, gear, ripple):
    """An individual's ripple phase turns its gear error too: their sum is what a gear has."""
    given = with_truth(_turned(0.2, 0.1), _turned(0.2, 0.5), BLOCKS[block])
    phase = given.gear_error_phase + given.ripple_phase[:, None]
    assert phase == pytest.approx(np.full((6, 4), gear))
    assert given.ripple_phase == pytest.approx(0.1 if ripple == 0.3 else ripple)


def test_what_a_twin_predicts_is_taken_from_the_robot():
    run = uncorrected(Cut(pose="p2", speed=0.08), Drawn(1001), Tally())
    assert run.left(run.tool) < SAMPLED
    program = run.motion.position - run.motion.position[0]
    assert run.left(program) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("median", "worst", "failing"),
    [(0.099, 0.249, 0), (0.101, 0.2, 1), (0.05, 0.251, 1), (0.101, 1.1, 3)],
)
def test_first_cuts_by_an_imu_have_bounds_of_their_own(median, worst, failing):
    left = np.append(np.full(29, median), worst)
    found = first_cut_imu.Found(1, 0, left, np.arange(30) < 27, 1.0)
    failed = [v.statement for v in first_cut_imu.verdicts([found]) if not v.holds]
    assert len(failed) == failing, failed
    assert len(first_cut_imu._row(found)) == len(first_cut_imu.COLUMNS)


@pytest.mark.parametrize(("inside", "holds"), [(25, False), (26, True), (28, True), (29, False)])
def test_an_interval_by_an_imu_that_holds_too_few_or_too_many_errors_fails(inside, holds):
    found = first_cut_imu.Found(1, 0, np.full(30, 0.05), np.arange(30) < inside, 1.0)
    assert first_cut_imu.verdicts([found])[-1].holds == holds


def test_the_interval_of_a_task_that_is_not_corrected_does_not_count():
    ends = SimpleNamespace(low=1.0, high=3.0)
    corrections = [SimpleNamespace(prediction=ends, trusted=t) for t in (True, True, True, False)]
    inside = first_cut.in_its_interval(np.array([1.0, 3.1, 0.9, 2.0]), corrections)
    assert inside.tolist() == [True, False, False]


def test_each_count_of_cuts_has_a_verdict_on_its_interval():
    each, held = np.full(10, 0.01), np.arange(10) < 9
    found = first_cut.Found(
        *(1, 0, dict.fromkeys(first_cut.COUNTS, each)),
        {10: held, 4: np.ones(10, dtype=bool), 2: np.arange(10) < 8},
        *(each, each, each, held, 1.0, 1.0),
    )
    failed = [v.statement for v in first_cut.verdicts([found]) if not v.holds]
    assert [name.split(":")[0] for name in failed if "interval" in name] == ["4 cuts", "2 cuts"]
    assert len(first_cut._row(found)) == len(first_cut.COLUMNS)
