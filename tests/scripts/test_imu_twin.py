"""Verifications of twins by IMU: what is measured, and what their verdicts let pass."""

from dataclasses import replace

import numpy as np
import pytest

from armside.scripts.verifications import first_cut
from armside.scripts.verifications.imu_twin import BLOCKS, uncorrected, with_truth
from armside.sim.laser import Cut
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
    run = uncorrected(Cut(pose="p2", speed=0.08), Drawn(1001))
    assert run.left(run.tool) < SAMPLED
    program = run.motion.position - run.motion.position[0]
    assert run.left(program) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("median", "worst", "failing"),
    [(0.05, 0.2, 0), (0.11, 0.2, 1), (0.05, 0.26, 1), (0.11, 1.1, 3)],
)
def test_first_cuts_by_an_imu_have_bounds_of_their_own(median, worst, failing):
    good = np.full(30, 0.01)
    by_imu = np.append(np.full(29, median), worst)
    found = first_cut.Found(
        *(1, 0, dict.fromkeys(first_cut.COUNTS, good), by_imu),
        *(np.arange(30) < 27, good, good, np.array([0.5, 0.01]), np.array([True, False])),
        *(1.0, 1.0),
    )
    statements = [v.statement for v in first_cut.verdicts([found]) if not v.holds]
    assert len(statements) == failing, statements
    assert len(first_cut._row(found)) == len(first_cut.COLUMNS)
    tracked = replace(found, by_imu=good)
    assert all(verdict.holds for verdict in first_cut.verdicts([tracked]))
