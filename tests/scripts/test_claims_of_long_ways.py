"""The claims of long ways fail where one cut leaves its bar, and hold on a short slice."""

from dataclasses import replace

import numpy as np
import pytest

from armside.scripts.jobs.store import Store
from armside.scripts.verifications.long_way import DEVELOPMENT, POSES, long_way, verdicts
from armside.scripts.verifications.long_way_cut import TASKS, Found, WayJob, found_of
from armside.sim.notes import Cause

pytestmark = pytest.mark.usefixtures("quick_identification")

GOOD = [
    Found(
        seed=seed,
        pose="p1",
        task=task,
        start=1e-4,
        estimate=1e-5,
        tracker=5e-6,
        nees=3.0,
        silent=False,
        notes=(),
    )
    for seed in range(3)
    for task in TASKS
]


def failing(found: list[Found]) -> list[str]:
    return [check.statement.split(":")[0] for check in verdicts(found) if not check.holds]


def test_good_cuts_hold():
    assert failing(GOOD) == []


@pytest.mark.parametrize(
    ("change", "statement"),
    [
        ({"estimate": 0.26e-4}, "estimate after five updates over k = 0"),
        ({"tracker": 0.11e-4}, "tracker after five updates over k = 0"),
        ({"silent": True}, "never done while the truth has grown (1 of 15 are)"),
    ],
)
def test_one_cut_beyond_its_bar_fails(change: dict, statement: str):
    assert failing([*GOOD[:-1], replace(GOOD[-1], **change)]) == [statement]


def test_an_estimate_above_its_start_fails_twice():
    worse = failing([*GOOD[:-1], replace(GOOD[-1], estimate=1.01e-4)])
    assert worse[-1] == "the estimate never ends above k = 0 (1 of 15 do)"


def test_the_median_and_the_consistency_have_bars_of_their_own():
    assert failing([replace(one, estimate=0.16e-4) for one in GOOD]) == ["the same"]
    slow = next(iter(TASKS))
    doubtful = [replace(one, nees=10.1 if one.task == slow else 1.0) for one in GOOD]
    assert failing(doubtful) == ["NEES of the tool, mean of the worst contour"]


def test_seeds_that_judge_are_not_those_of_development():
    assert min(DEVELOPMENT) >= 100


def test_an_outline_of_700_mm_is_learned_from_the_estimate():
    """The quick slice: one cut of a seed of development."""
    job = WayJob(seed=100, pose="p2", task="300 x 80 mm, 80 mm/s")
    assert failing([found_of(job, job.run())]) == []


def test_cuts_that_are_kept_are_not_made_again(tmp_path):
    """All cuts of a seed that are stored: none is left to run, and the table has theirs."""
    store, size = Store(tmp_path), {}
    for i, (pose, task) in enumerate((pose, task) for pose in POSES for task in TASKS):
        values = {"start": 1e-4, "estimate": (1 + i) * 1e-6, "tracker": 5e-6, "nees": 3.0}
        arrays = {name: np.array(value) for name, value in values.items()}
        said = {"causes": np.array(["guard"]), "texts": np.array(["went back"])}
        job = WayJob(seed=7, pose=pose, task=task)
        store.save(job, arrays | said | {"silent": np.array(i == 3)})
        size[pose, task] = (1 + i) * 1.0
    table = long_way([7], tmp_path)
    assert {row[1:3]: pytest.approx(row[4]) for row in table.rows} == size
    assert [check.statement for check in table.verdicts if not check.holds] == [
        "never done while the truth has grown (1 of 15 are)"
    ]
    (note,) = table.notes
    assert note.cause is Cause.GUARD
    assert "in 15 of 15 learned cuts" in note.text
