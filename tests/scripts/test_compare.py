"""`armside compare`: every way to learn a cut in one table, gone on from and taken elsewhere."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from armside import assets
from armside.scripts.commands.compare import _rows
from armside.scripts.cutting.comparison import CompareCfg, cases_of, starts_of
from armside.scripts.cutting.earlier import started as start_from
from armside.scripts.shell.options import Common
from armside.sim.records.files import InputError

from .ran import ran

WAYS = ["motor", "estimate", "tracker", "oracle"]
ROBOT = str(assets.IRB1400_XML.parent / "two_link.toml")
"""Two axes: its springs are identified in a second."""
CUTS = ("--robot", ROBOT, "--poses", "p1", "--speeds", "60", "--seed", "2")
LINE = ("compare", *CUTS)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    out = tmp_path_factory.mktemp("compare") / "first"
    ran(out, *LINE, "--iterations", 1)
    return out


def test_updates_in_two_comparisons_are_those_of_one_to_the_last_bit(first, tmp_path):
    once = ran(tmp_path / "once", *LINE, "--iterations", 3)
    again = ran(tmp_path / "b", "compare", "--from", first, "--iterations", 2)
    assert (once["k"], again["k"]) == ([0, 1, 2, 3], [0, 2, 3])
    for whole, parts in zip(once["comparisons"], again["comparisons"], strict=True):
        assert parts["arm_rms"] == [whole["arm_rms"][k] for k in again["k"]]
    assert once["started_from"] is None
    assert again["started_from"] == {
        "run": str(first),
        "k": 1,
        "how": "its last runs",
        "changed": [],
    }
    files = {"summary.json", "compare.png", "replay.rrd", "state.npz"}
    assert {file.name for file in (tmp_path / "once").iterdir()} == files
    assert [row["measure"] for row in once["comparisons"]] == WAYS
    motor, *tool = (row["arm_rms"][-1] for row in once["comparisons"])
    assert all(value < 0.5 * motor for value in tool)


def test_the_estimate_is_that_of_laser_for_the_same_cut_robot_and_seed(first, tmp_path):
    compared = json.loads((first / "summary.json").read_text())["comparisons"]
    (estimate,) = (row["arm_rms"] for row in compared if row["measure"] == "estimate")
    words = ("--robot", ROBOT, "--pose", "p1", "--speed", 60, "--seed", 2, "--iterations", 1)
    alone = ran(tmp_path / "laser", "laser", *words, "--measure", "estimate")
    found = [each["arm_rms"] for each in alone["iterations"]]
    assert found == pytest.approx(estimate, rel=1e-9)


def started(first, robot=ROBOT, **options):
    cfg = CompareCfg(robot=robot, poses=("p1",), **options)
    return start_from(first, "compare", cfg, Common(seed=2))


def test_each_way_takes_its_own_correction_to_another_speed(first):
    cfg, common, before = started(first, speeds=(80.0,))
    assert before.changed == ("speeds",)
    (case,) = cases_of(cfg, common.seed)
    starts = starts_of(before, 0, case)
    assert list(starts) == WAYS
    n = len(case.experiment().loaded.reference)
    for way, start in starts.items():
        learned = before.states[f"0 {way}"].loop.correction
        assert start.shape == (n, 2) != learned.shape
        np.testing.assert_allclose(np.ptp(start, axis=0), np.ptp(learned, axis=0), rtol=0.02)


def test_what_a_comparison_cannot_start_from_is_named(first, tmp_path):
    cfg, common, before = started(first, stiffness_error=10.0)
    (case,) = cases_of(cfg, common.seed)
    elsewhere = replace(case, cut=replace(case.cut, pose="p2"))
    with pytest.raises(InputError, match=r"no cut at p2\. It has: p1"):
        starts_of(before, 0, elsewhere)
    with pytest.raises(InputError, match="has another robot"):
        started(first, robot="irb1400")
    summary = json.loads((first / "summary.json").read_text())
    summary["comparisons"][1]["diverged"] = True
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(InputError, match="learning from estimate diverged at p1"):
        started(tmp_path)


def test_a_row_of_a_comparison_has_diverged_where_its_last_run_has():
    runs = [
        SimpleNamespace(correction=np.zeros(2), tool=SimpleNamespace(rms=1e-3), diverged=k == 2)
        for k in range(3)
    ]
    made = SimpleNamespace(motion=SimpleNamespace(reached_speed=0.06))
    case = SimpleNamespace(experiment=lambda: made, cut=SimpleNamespace(pose="p1", speed=0.06))
    rows = _rows(case, {"motor": runs, "tracker": runs[:2]})
    assert [row["diverged"] for row in rows] == [True, False]
