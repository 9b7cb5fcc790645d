"""`armside cut`: from a drawing to a learned part, and back from its folder."""

import json
import sys

import ezdxf
import numpy as np
import pytest

from armside.scripts.cli import main
from armside.scripts.cutting.cut_run import Ready
from armside.sim.records import read_run

from .ran import ran

PLATE = ((0, 0), (40, 0), (40, 25), (0, 25))


def plate(folder, name="plate.dxf"):
    """40 x 25 mm with a round hole and a square one, sharp corners."""
    document = ezdxf.new(units=4)  # pyright: ignore[reportPrivateImportUsage]
    space = document.modelspace()
    space.add_lwpolyline(PLATE, close=True)
    space.add_circle((10, 12), 4.0)
    space.add_lwpolyline([(22, 8), (32, 8), (32, 17), (22, 17)], close=True)
    document.saveas(folder / name)
    return folder / name


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cut") / "run"


@pytest.fixture(scope="module")
def outcome(folder):
    return ran(folder, "cut", plate(folder.parent), "--speed 60 --iterations 2 --pose p2")


def test_every_contour_has_its_own_measures_in_the_order_of_the_cuts(outcome):
    assert [contour["kind"] for contour in outcome["contours"]] == ["hole", "hole", "outline"]
    outline = outcome["contours"][-1]
    # Half a beam outside, corners of 0.5 mm.
    assert outline["length"] == pytest.approx(0.130 - 8 * 5e-4 + 2 * np.pi * 6e-4)
    for contour in outcome["contours"]:
        assert [row["k"] for row in contour["iterations"]] == [0, 1, 2]
        for row in contour["iterations"]:
            assert 0.0 < row["arm_rms_true"] < row["arm_maxdev_true"] < 2e-3
            assert row["arm_rms"] == pytest.approx(row["arm_rms_true"], rel=0.2)
    holes = [c["iterations"][-1]["arm_roundness"] for c in outcome["contours"]]
    assert sum(value is not None for value in holes) == 1, "one hole is round"


def test_corners_and_kerf_are_measured_where_there_are_any(outcome):
    for contour in outcome["contours"]:
        assert [row["k"] for row in contour["kerf"]] == [0, 2]
        for row in contour["kerf"]:
            assert row["width_true"] == pytest.approx(2e-4, rel=0.02)
            assert row["width_true"] < row["widest_true"] < 2e-3
        rows = contour["iterations"]
        is_round = rows[0]["arm_roundness"] is not None
        for row in rows:
            assert (row["arm_corner_true"] is None) == is_round
            assert is_round or 0.0 < row["arm_corner_true"] <= row["arm_maxdev_true"]


def test_the_motors_learn_all_contours_in_one_run(outcome):
    first, *_, last = outcome["iterations"]
    assert max(last["motor_inf_normalised"]) < 0.3
    assert last["arm_rms"] < first["arm_rms"]
    contours = [contour["iterations"] for contour in outcome["contours"]]
    length = [contour["length"] for contour in outcome["contours"]]
    rms = [rows[-1]["arm_rms"] for rows in contours]
    assert last["arm_rms"] == pytest.approx(np.sqrt(np.average(np.square(rms), weights=length)))


def test_a_part_takes_the_time_of_its_moves_and_cuts(outcome):
    cuts = sum(contour["seconds"] for contour in outcome["contours"])
    assert cuts + 3 * 0.3 < outcome["seconds"] < cuts + 3 * 0.3 + 6.0


def test_speeds_that_a_bend_lowers_are_said(outcome):
    (note,) = [n["text"] for n in outcome["notes"] if n["cause"] == "speed"]
    assert note.startswith("the speed is lowered from 60 mm/s to 22.8 mm/s in bends of 2 of 3")


def test_the_folder_is_small_and_replay_and_measure_read_it(folder, outcome, tmp_path, capsys):
    assert sum(file.stat().st_size for file in folder.iterdir()) < 8e6
    assert {"plan.png", "part.png", "errors.png", "replay.rrd"} <= {
        f.name for f in folder.iterdir()
    }
    run = read_run(folder)
    assert [one.k for one in run.signals.runs] == [0, 2]
    assert main(["measure", str(folder / "signals.parquet"), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["iterations"]
    for row in rows:
        assert row["arm_rms"] == pytest.approx(outcome["iterations"][row["k"]]["arm_rms"], rel=1e-9)
    assert main(["replay", str(folder), "--save", str(tmp_path / "a.rrd"), "--quiet"]) == 0


def test_a_plan_moves_nothing(tmp_path, capsys):
    words = ["cut", str(plate(tmp_path)), "--plan-only", "--out", str(tmp_path / "plan")]
    assert main(words) == 0
    assert "Plan: 3 contours in" in capsys.readouterr().out
    assert {f.name for f in (tmp_path / "plan").iterdir()} == {"plan.png", "summary.json"}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("--pose p9", "Unknown pose 'p9'"),
        ("--speed 0", "speed must be 0.001 to 10000 mm/s, got 0"),
        ("--units inch --pose p3 --robot irb1400", "out of reach at ("),
        ("--layers CUT", "there is no layer 'CUT'"),
        ("--beam 9", "the beam of 9 mm is too wide"),
        ("--speed 0.001", "would take about"),
    ],
)
def test_what_cannot_be_cut_is_refused_in_one_line(more, said, tmp_path, bad_input):
    bad_input(f"cut {plate(tmp_path)} {more}", said)


def test_a_missing_package_is_named(tmp_path, bad_input, monkeypatch):
    file = plate(tmp_path)
    monkeypatch.delitem(sys.modules, "armside.sim.part.dxf", raising=False)
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    bad_input(f"cut {file} --plan-only", "pip install 'armside[parts]'")


@pytest.mark.parametrize(("given", "asked"), [("2.5", 0.025), ("0", None)])
def test_a_contour_has_converged_by_less_than_the_given_per_cent(
    monkeypatch, tmp_path, given, asked
):
    noted = []

    def iterations(_, count, converged=None):
        noted.append((count, converged))
        raise RuntimeError("noted")

    monkeypatch.setattr(Ready, "iterations", iterations)
    words = ["--iterations", "3", "--converged", given, "--quiet", "--out", str(tmp_path / "run")]
    assert main(["cut", str(plate(tmp_path)), *words]) == 1
    assert noted == [(3, pytest.approx(asked) if asked else None)]
