"""`armside commission` and `armside laser --twin`: from recorded cuts to a right first run."""

import json
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from armside.scripts import cli
from armside.scripts.commands import commission as command
from armside.scripts.jobs.grid import Point
from armside.scripts.jobs.resolved import key_of
from armside.sim.instruments.laser_tracker import LaserTrackerCfg
from armside.sim.notes import Cause
from armside.sim.twin import twin as library
from armside.sim.twin.commission import Choice
from armside.sim.twin.own_servo import TAPS, OwnServo
from armside.sim.twin.twin import Twin

INDIVIDUAL = "2001"  # of the shared twin
SCATTER = 6e-6
"""[m], by which noise of an IMU moves a corrected cut from run to run: 2 to 5 um were seen."""
pytestmark = pytest.mark.usefixtures("quick_identification")


@pytest.fixture(scope="module")
def twin(commissioned):
    """Folder of a twin that was commissioned from one cut, and its summary."""
    return commissioned / "twin", json.loads((commissioned / "printed.json").read_text())


def test_commissioning_leaves_a_twin_with_its_pictures(twin):
    folder, summary = twin
    names = {"summary.json", "twin.json", "covariance.npy", "friction.png", "residuals.png"}
    assert {file.name for file in folder.iterdir()} == names
    assert summary["cuts"][0]["held_out"] is None  # the only cut cannot be left out
    assert summary["cuts"][0]["within"] < 50e-6
    assert "friction_constant 1" not in summary["not_identified"]
    assert "gear_error 6 1 1" in summary["not_identified"]  # the tool lies on axis 6


def test_a_first_cut_by_a_twin_is_predicted_and_right(summary_of, twin):
    found = summary_of(f"laser --twin {twin[0]} --individual {INDIVIDUAL} --iterations 0 --out run")
    predicted = found["predicted"]
    assert predicted["trusted"]
    assert predicted["interval"] is None  # of a twin of one cut
    assert 0.0 < predicted["arm_rms"] < 0.3 * predicted["uncorrected"]
    assert found["iterations"][0]["arm_rms_true"] < 0.3 * predicted["uncorrected"]
    assert found["twin"]["friction"] == pytest.approx([1.0] * 6, abs=0.15)


def test_a_whole_part_is_corrected_at_its_first_run(summary_of, twin, tmp_path):
    """By a twin of a single cut elsewhere; learning from the motors goes on around it."""
    plate = "corner = 1\npoints = [[0, 0], [30, 0], [30, 20], [0, 20]]\n"
    (tmp_path / "plate.toml").write_text(plate)
    cut = f"cut plate.toml --individual {INDIVIDUAL} --iterations 0 --twin {twin[0]}"
    found = summary_of(f"{cut} --out run")
    assert found["predicted"]["trusted"]
    (row,) = found["iterations"]
    assert row["arm_rms_true"] < 0.3 * found["predicted"]["uncorrected"]
    again = summary_of("cut --from run --iterations 1")
    assert again["iterations"][0] == row
    assert again["iterations"][1]["arm_rms_true"] < 1.3 * row["arm_rms_true"]


def test_targets_are_learned_in_a_twin_before_the_first_run(
    summary_of, twin, tmp_path, monkeypatch
):
    """The error of that run is predicted; of a twin that is not trusted none are taken."""
    plate = "corner = 1\npoints = [[0, 0], [15, 0], [15, 10], [0, 10]]\n"
    (tmp_path / "plate.toml").write_text(plate)
    plain = f"cut plate.toml --individual {INDIVIDUAL} --iterations 0 --measure tracker"
    plain += " --as-program rapid --spacing 2"
    cut = f"{plain} --twin {twin[0]}"
    found = summary_of(f"{cut} --out run")
    predicted, (row,) = found["predicted"], found["iterations"]
    assert predicted["trusted"]
    assert predicted["interval"] is None  # factors are not those of programs
    assert 0.0 < predicted["arm_rms"] < 0.3 * predicted["uncorrected"]
    assert row["arm_rms_true"] < 0.3 * predicted["uncorrected"]
    assert found["program"]["largest_offset"] > 1e-4
    again = summary_of("cut --from run --iterations 1")
    assert again["iterations"][0] == row
    assert again["iterations"][1]["arm_rms_true"] < row["arm_rms_true"] + SCATTER
    monkeypatch.setattr("armside.sim.twin.prediction.LARGEST_FRACTION", 0.0)
    found = summary_of(cut)
    assert not found["predicted"]["trusted"]
    assert any("the twin is not trusted here" in note["text"] for note in found["notes"])
    assert found["program"]["largest_offset"] == 0.0
    assert found["iterations"] == summary_of(plain)["iterations"]


def test_a_first_cut_whose_beam_is_lost_keeps_its_results(armside, twin, tmp_path, monkeypatch):
    """Friction is followed by torque alone; what the tracker would have measured is missing."""
    narrow = partial(LaserTrackerCfg, acceptance_angle=1e-5)
    monkeypatch.setattr("armside.sim.laser.experiment.LaserTrackerCfg", narrow)
    line = f"laser --twin {twin[0]} --individual {INDIVIDUAL} --iterations 0"
    status, out, err = armside(f"{line} --out {tmp_path / 'run'}")
    assert (status, err) == (0, "")
    assert "First cut by the twin: not measured" in out
    found = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert found["beam_lost"] == [True]
    assert found["iterations"][0]["arm_rms"] is None
    assert found["twin"]["friction"] == pytest.approx([1.0] * 6, abs=0.15)


@pytest.mark.parametrize("measure", ["estimate", "tracker"])
def test_learning_goes_on_from_a_twin_and_does_not_lose_what_it_knew(summary_of, twin, measure):
    """An estimate is off by what its arm lacks, but as much in the twin's run, which it follows."""
    line = f"laser --twin {twin[0]} --individual {INDIVIDUAL} --measure {measure} --iterations 3"
    found = summary_of(f"{line} --pose p2 --shape hexagon --speed 60")
    first, *others = [row["arm_rms_true"] for row in found["iterations"]]
    assert len(others) == 3
    assert max(others) < first + SCATTER


def test_a_twin_that_is_not_trusted_leaves_learning_as_it_is_without(summary_of, twin, monkeypatch):
    monkeypatch.setattr("armside.sim.twin.prediction.LARGEST_FRACTION", 0.0)
    library._learned.cache_clear()
    line = f"laser --individual {INDIVIDUAL} --iterations 2"
    by_twin, plain = summary_of(f"{line} --twin {twin[0]}"), summary_of(line)
    library._learned.cache_clear()
    assert not by_twin["predicted"]["trusted"]
    assert by_twin["iterations"] == plain["iterations"]


def test_a_comparison_has_the_twin_beside_what_is_learned_from(summary_of, twin):
    line = f"compare --twin {twin[0]} --individual {INDIVIDUAL} --poses p1 --speeds 40"
    found = summary_of(f"{line} --iterations 1 --out c")
    rows = {row["measure"]: row for row in found["comparisons"]}
    assert list(rows) == ["motor", "estimate", "tracker", "oracle", "twin"]
    assert {row["uncorrected"] for row in rows.values()} == {rows["motor"]["arm_rms"][0]}
    first, then = rows["twin"]["arm_rms"]
    assert first < 0.3 * rows["motor"]["arm_rms"][0]
    assert then < first + SCATTER


class TestSweep:
    """A twin is an option of a sweep, known by its content."""

    def test_each_cut_is_learned_once_whatever_the_noise(self, armside, twin, monkeypatch):
        made = []
        correction = Twin.correction
        monkeypatch.setattr(Twin, "correction", lambda *of: made.append(of) or correction(*of))
        library._learned.cache_clear()
        options = {"twin": twin[0], "individual": int(INDIVIDUAL), "iterations": 0}
        rows = [
            Point(key_of(options | more, seed), options | more, seed).run()
            for seed in (0, 1)
            for more in ({}, {"gamma": (0.5,)}, {"friction_drift": 10.0})
        ]
        assert len(made) == 1
        assert [row["status"] for row in rows] == ["done"] * 6
        for row in rows:
            assert row["twin"] == str(twin[0])
            assert row["arm_rms_true"][0] < 3.0 * row["predicted"]
        assert len({row["arm_rms_true"][0] for row in rows}) == 4  # gain has no part in run 0

    def test_a_key_is_of_the_content(self, twin, tmp_path):
        copy = tmp_path / "elsewhere"
        shutil.copytree(twin[0], copy)
        one, other = ({"twin": folder} for folder in (twin[0], copy))
        assert key_of(one, 0) == key_of(other, 0) != key_of({}, 0)
        file = copy / "twin.json"
        file.write_text(
            file.read_text().replace('"friction": [\n    1.0', '"friction": [\n    1.1')
        )
        assert key_of(one, 0) != key_of(other, 0)

    @pytest.mark.parametrize(
        ("axes", "said"),
        [
            ("twin=nowhere", "nowhere holds no twin.json"),
            ("twin={twin} robot=irb1400", "the twin is of the robot large"),
        ],
    )
    def test_a_twin_that_cannot_serve_is_refused(self, bad_input, twin, axes, said):
        bad_input(f"sweep {axes.format(twin=twin[0])}", said)


def test_an_imu_takes_the_place_of_the_tracker(armside, tmp_path):
    line = f"commission --measure imu --individual {INDIVIDUAL} --cuts 1 --out {tmp_path / 'twin'}"
    status, out, _ = armside(line)
    assert status == 0
    assert "What the twin leaves of the acceleration of the tool [× noise]" in " ".join(out.split())
    summary = json.loads((tmp_path / "twin" / "summary.json").read_text())
    assert summary["cuts"][0]["within"] < 2.0  # white noise below 10 Hz alone leaves 0.8
    assert "gear_stiffness 1" not in summary["not_identified"]
    assert {"position 1 1", "orientation 6 3"} <= set(summary["not_identified"])
    assert json.loads((tmp_path / "twin" / "twin.json").read_text())["sensor"] == "imu"


def singular(*_args, **_kwargs):
    raise np.linalg.LinAlgError("Singular matrix")


def test_a_failure_of_the_identification_is_not_bad_input(armside, monkeypatch):
    """Only a recording that cannot be of the robot is."""
    from armside.sim.twin import commission
    from armside.sim.twin.recordings import ImplausibleError

    monkeypatch.setattr(commission, "identify", singular)
    status, _, err = armside("commission --cuts 1")
    assert (status, err.count("\n")) == (1, 1)
    assert "failed with LinAlgError" in err

    def another_robot(*_args, **_kwargs):
        raise ImplausibleError("cut-1: another robot")

    monkeypatch.setattr(commission, "identify", another_robot)
    assert armside("commission --cuts 1") == (2, "", "armside: cut-1: another robot\n")


def test_a_failure_of_learning_in_a_twin_is_not_bad_input(armside, twin, monkeypatch):
    from armside.sim.twin import twin as module

    monkeypatch.setattr(module, "correct", singular)
    status, _, err = armside(f"laser --iterations 0 --radius 6 --twin {twin[0]}")
    assert (status, err.count("\n")) == (1, 1)
    assert "failed with LinAlgError" in err
    status, _, err = armside(f"laser --robot irb1400 --twin {twin[0]}")
    assert (status, "the twin is of the robot large" in err) == (2, True)


def test_the_plan_states_how_long_each_record_takes(armside, monkeypatch):
    """A circle of 126 mm at 80 mm/s: 1.6 s around, the lead-in and the rests."""
    monkeypatch.setattr(command.commissioning, "chosen", lambda *_, **__: [Choice(0, 79.0)])
    _, out, _ = armside("commission --choose")
    (row,) = (line for line in out.splitlines() if "Circle" in line)
    speed, seconds = (float(cell) for cell in row.split("│")[4:6])
    assert speed == 80.0
    assert 0.126 / 0.080 < seconds < 2 * 0.126 / 0.080


LEFT_OUT = "square-ccw hexagon-ccw slot-ccw circle-ccw hexagon-cw square-cw slot-cw"


@pytest.fixture(scope="module")
def coupon(made_once):
    """Folder of a coupon as an individual that is not corrected cut it, of the scan of its sheet,
    and of the scanner that a grid shows."""

    def cut(folder):
        for line in (
            f"commission --coupon-sheet {folder} --sheet 100 100 --individual {INDIVIDUAL}",
            f"scan calibrate {folder}/grid.png --pitch 10 --out {folder}/scanner",
        ):
            assert cli.main(line.split()) == 0

    return made_once("coupon", cut)


def test_a_scanned_coupon_shows_where_an_uncorrected_robot_cut(coupon, summary_of):
    line = f"scan read {coupon}/scan.png --contours {coupon}/coupon.dxf --drawn beam"
    found = summary_of(f"{line} --scanner {coupon}/scanner --out read")
    assert found["scale"] == 1e-4  # which a cut that is too small does not widen
    left_out = [note.split(": ")[1].split() for note in found["notes"] if "left out" in note]
    assert all(float(lost) < 0.05 * float(of) for lost, _, of, *_ in left_out), left_out
    plan = json.loads((Path(coupon) / "coupon.json").read_text("utf-8"))
    named = [of["contour"] for of in found["contours"]]
    assert named == [*(of["name"] for of in plan["contours"]), "mark", "kerf"]
    *cut, mark, kerf = (of["rms"] for of in found["contours"])
    assert max(cut) > 150e-6
    assert max(mark, kerf) < 20e-6  # drawn as they should be, but for the sheet's common place


@pytest.mark.parametrize("measure", ["scan", f"imu --individual {INDIVIDUAL} --cuts 1"])
def test_a_scanned_coupon_makes_a_twin(coupon, summary_of, one_step_commissioning, measure):
    files = f"--coupon {coupon}/scan.png --scanner {coupon}/scanner/scanner.json"
    found = summary_of(f"commission --measure {measure} {files} --leave-out {LEFT_OUT} --out twin")
    *of_imu, circle = found["cuts"]
    assert [cut["name"] for cut in of_imu] == (["cut-1"] if "imu" in measure else [])
    assert circle["name"] == "circle-cw"
    assert circle["within"] < 20e-6


def test_cuts_that_no_one_robot_explains_are_noted():
    """An IMU of one robot beside the coupon of another: held out 7 times its noise, seen."""
    cuts = [{"held_out": out} for out in (7.0, 6e-6, 9e-6)]
    (note,) = command._suspicious(cuts, ["imu", "scan", "scan"])
    assert "are all cuts of one robot with one tool?" in note.text
    assert "leaves 7 " in note.text
    assert command._suspicious([{"held_out": None}, *cuts[1:]], ["imu", "scan", "scan"]) == []
    assert command._suspicious([{"held_out": 1.1}], ["imu"]) == []


def test_what_a_twin_knows_beyond_its_type_is_said(twin):
    """1.2 times 3 % of the rated torque, which is the effect's median size."""
    plain = Twin.load(twin[0])
    assert command._besides(plain) == []
    of_its_own = replace(plain, servo=OwnServo(np.zeros(TAPS), 0.4, 0.0), hysteresis=True)
    at = of_its_own.parameters.at("hysteresis").start
    notes = command._besides(replace(of_its_own, theta=np.insert(plain.theta, at, 1.2)))
    assert [note.cause for note in notes] == [Cause.TWIN, Cause.TWIN]
    assert "the servo is not the type's" in notes[0].text
    assert "hysteresis, 3.6 % of their rated torque" in notes[1].text
