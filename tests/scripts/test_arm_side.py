"""Learning on the arm side as its users see it."""

import json

import numpy as np
import pytest

from armside.scripts.cli import main
from armside.sim.laser import Cut, learn
from armside.sim.robot.effects import Effect

from .ran import ran

pytestmark = pytest.mark.usefixtures("quick_identification")


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "springs"
    ran(out, "identify --pose p2")
    return out


def test_identification_is_scored_against_the_truth(identified):
    found = json.loads((identified / "summary.json").read_text())
    assert found["config"]["experiment"] == "identify"
    consistency = found["consistency"]
    assert 0.7 * 6 < consistency["nis"] < 1.5 * 6
    assert 1.0 < consistency["nees"] < 9.0, "3 where standard deviations are right"
    truth = found["truth"]
    assert truth["identified_modes"][0] == pytest.approx(truth["locked_modes"][0], rel=0.1)
    assert found["springs"]["clock_offset"] == pytest.approx(truth["clock_offset"], abs=2e-3)
    names = [p["name"] for p in found["parameters"]]
    assert {"stiffness 1", "stiffness 1 across 2", "stiffness 6", "lost motion"} <= set(names)
    assert all(p["standard_deviation"] > 0.0 for p in found["parameters"])


def test_a_laser_run_learns_from_the_estimate_with_stored_springs(identified, tmp_path):
    summary = ran(tmp_path, f"laser --measure estimate --pose p2 --identification {identified}")
    rows = summary["iterations"]
    assert [r["k"] for r in rows] == list(range(6))
    assert rows[-1]["arm_rms"] < 0.15 * rows[0]["arm_rms"]
    assert summary["config"]["measure"] == "estimate"


def test_springs_serve_nearby_with_another_tool_and_another_unit(identified, tmp_path):
    """Half a metre off, 60 kg instead of 40, and an IMU whose clock started at another time."""
    line = "laser --measure estimate --position 1500 0 1599 --payload 60 --seed 1 --iterations 3"
    rows = ran(tmp_path, line, "--identification", identified)["iterations"]
    assert rows[-1]["arm_rms"] < 0.3 * rows[0]["arm_rms"]


def test_springs_of_another_robot_are_refused(identified, bad_input):
    said = "identified on robot large, not on irb1400"
    bad_input(f"laser --measure estimate --robot irb1400 --identification {identified}", said)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda springs: springs.pop("mounting"), "springs lack mounting"),
        (lambda springs: springs.update(damping=[1.0]), "springs.damping"),
        (lambda springs: springs.update(clock_offset="soon"), "springs.clock_offset"),
    ],
)
def test_springs_that_are_not_whole_are_named(change, said, identified, tmp_path, bad_input):
    stored = json.loads((identified / "summary.json").read_text())
    change(stored["springs"])
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(stored))
    line = f"laser --measure estimate --pose p2 --identification {tmp_path}"
    assert str(file) in bad_input(line, said)


def test_learning_from_the_estimate_needs_one_run_to_commission():
    """`make bench NAME=estimation` times it."""
    cut = Cut(pose="p1", without=tuple(Effect))
    iterations = list(learn(cut, measure="estimate", seed=1))
    assert iterations[-1].tool.rms < 0.15 * iterations[0].tool.rms


def test_the_gears_that_are_assumed_are_off_by_up_to_the_given_per_cent(monkeypatch, tmp_path):
    """Six draws from -20 to 20 %: the largest is below 10 % once in 64."""
    assumed = []

    def noted(_, arm):
        assumed.append(arm.stiffness)
        raise RuntimeError("noted")

    monkeypatch.setattr("armside.sim.laser.identification.identified", noted)
    for error in (0, 20):
        line = f"identify --stiffness-error {error} --quiet --out {tmp_path / str(error)}"
        assert main(line.split()) == 1
    right, wrong = assumed
    assert 0.1 < np.abs(wrong / right - 1.0).max() <= 0.2
