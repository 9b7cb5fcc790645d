"""Verifications of twins by IMU: what is measured, and what their verdicts let pass."""

import numpy as np
import pytest

from armside.scripts.verifications import first_cut_imu
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
