"""Learning on the arm side as its users see it, and the claim for one seed at one pose."""

import json

import pytest

from armside.scripts.arm_side import GEAR_EFFECTS, Case, rms
from armside.scripts.cli import main
from armside.scripts.verifications.estimation import row, verdicts
from armside.sim.estimation.arm_learning import ArmLearningCfg


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "springs"
    assert main(["identify", "--pose", "p2", "--out", str(out), "--quiet"]) == 0
    return out


def test_identification_is_scored_against_the_truth(identified):
    found = json.loads((identified / "summary.json").read_text())
    assert found["config"]["experiment"] == "identify"
    consistency = found["consistency"]
    assert 0.7 * 6 < consistency["nis"] < 1.5 * 6
    assert consistency["nees"] > 3.0, "left to gear errors, which the filter does not model"
    truth = found["truth"]
    assert truth["identified_modes"][0] == pytest.approx(truth["locked_modes"][0], rel=0.1)
    assert found["springs"]["clock_offset"] == pytest.approx(truth["clock_offset"], abs=2e-3)
    names = [p["name"] for p in found["parameters"]]
    assert names[:2] == ["stiffness 1", "stiffness 2"]
    assert all(p["standard_deviation"] > 0.0 for p in found["parameters"])


def test_a_laser_run_learns_from_the_estimate_with_stored_springs(identified, tmp_path):
    args = ["laser", "--measure", "estimate", "--pose", "p2", "--quiet"]
    assert main([*args, "--identification", str(identified), "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    rows = summary["iterations"]
    assert [r["k"] for r in rows] == list(range(6))
    assert rows[-1]["arm_rms"] < 0.15 * rows[0]["arm_rms"]
    assert summary["config"]["measure"] == "estimate"


def test_springs_of_another_pose_are_refused(identified, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    args = ["laser", "--measure", "estimate", "--pose", "p1", "--identification", str(identified)]
    assert main(args) == 2
    assert "identified at pose p2" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda springs: springs.pop("mounting"), "springs lack mounting"),
        (lambda springs: springs.update(damping=[1.0]), "springs.damping"),
        (lambda springs: springs.update(clock_offset="soon"), "springs.clock_offset"),
    ],
)
def test_springs_that_are_not_whole_are_named(change, said, identified, tmp_path, capsys):
    stored = json.loads((identified / "summary.json").read_text())
    change(stored["springs"])
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(stored))
    args = ["laser", "--measure", "estimate", "--pose", "p2", "--identification", str(tmp_path)]
    assert main(args) == 2
    err = capsys.readouterr().err
    assert said in err
    assert str(file) in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--law inverse", "--measure estimate"),
        ("--measure estimate --gamma 1 1 1 1 1 1", "gamma takes one value"),
        ("--measure estimate --robot irb1400 --pose p1", "open chain"),
        ("--measure estimate --identification nowhere", "no identification"),
        ("--measure tracker --stiffness-error 100", "stiffness-error"),
        ("--path-acceleration 0", "path-acceleration"),
    ],
)
def test_bad_input_is_one_clear_line(words, said, bad_input):
    bad_input(f"laser {words}", said)


def test_compare_puts_all_measures_side_by_side(tmp_path):
    args = ["compare", "--poses", "p2", "--speeds", "40", "--iterations", "3", "--quiet"]
    assert main([*args, "--out", str(tmp_path)]) == 0
    assert {f.name for f in tmp_path.iterdir()} == {"summary.json", "compare.png", "replay.rrd"}
    rows = json.loads((tmp_path / "summary.json").read_text())["comparisons"]
    assert [r["measure"] for r in rows] == ["motor", "estimate", "tracker", "oracle"]
    motor, *tool = (r["arm_rms"][-1] for r in rows)
    assert all(value < 0.5 * motor for value in tool)


def test_learning_from_the_estimate_identifies_springs_and_learns_within_five_updates():
    case = Case(pose="p1", seed=1, without=GEAR_EFFECTS)
    found = rms(list(case.on_arm_side(ArmLearningCfg(), 5)[1]))
    assert found[-1] < 0.15 * found[0]


def test_claim_holds_for_one_seed_at_one_pose():
    """Ten seeds at three poses: armside verify estimation."""
    failed = [v.statement for v in verdicts([row(0, "p2")]) if not v.holds]
    assert not failed
