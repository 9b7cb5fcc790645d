"""`armside laser` as its users see it: files, numbers, exit status, and one line for bad input."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from armside import assets
from armside.scripts.cli import main
from armside.scripts.cutting.cut_run import predicted_line as line
from armside.scripts.figures.laser_results import show
from armside.scripts.shell.console import Report, cell
from armside.scripts.shell.options import Common
from armside.sim.records.signals import read_signals

from .ran import ran
from .replay_content import content

FILES = {"summary.json", "individual.toml", "signals.parquet", "robot.xml", "replay.rrd"}
FILES |= {"state.npz", "circles.png", "errors.png", "kerf.png"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("runs") / "default"


@pytest.fixture(scope="module")
def summary(folder):
    return ran(folder, "laser")


def test_a_run_leaves_its_files(summary, folder):
    assert {file.name for file in folder.iterdir()} == FILES


def test_summary_says_what_was_asked_and_what_came_out(summary):
    config = summary["config"]
    assert (config["robot"], config["pose"], config["speed"], config["seed"]) == (
        "large",
        "p1",
        40,
        0,
    )
    assert set(config["versions"]) >= {"armside", "mujoco", "numpy", "python"}
    assert summary["status"] == "done"
    assert summary["limits_hit"] == []
    assert [row["k"] for row in summary["iterations"]] == list(range(6))
    for row in summary["iterations"]:
        assert len(row["motor_inf"]) == len(row["motor_two"]) == 6
        assert row["arm_rms"] == pytest.approx(row["arm_rms_true"], rel=0.05)


def test_summary_can_be_computed_again_from_the_signals(folder, summary):
    """Motor shaft angles: gear ratios of the large robot. Motor errors from r and y alone."""
    gear = np.array([220, 242.73, 242.73, 145, 180, 100])
    for run, row in zip(
        read_signals(folder / "signals.parquet").runs, summary["iterations"], strict=True
    ):
        error = (run.recording.reference - run.recording.motor_angle) * gear
        assert np.abs(error).max(axis=0) == pytest.approx(row["motor_inf"], rel=1e-12)
        assert np.sqrt((error**2).sum(axis=0)) == pytest.approx(row["motor_two"], rel=1e-12)


@pytest.mark.parametrize("without", [None, "motor_inf"], ids=["whole", "a measure missing"])
def test_the_one_table_of_a_run_is_that_of_readme_in_80_columns(
    summary, capsys, monkeypatch, without
):
    """k, worst motor, tool RMS, tool maximum, per cent of k = 0; a pipe, not a terminal."""
    monkeypatch.setenv("COLUMNS", "80")
    rows = [dict(row) for row in summary["iterations"]]
    if without:
        rows[-1][without] = [None] * 6
    show(Report(Common()), summary | {"iterations": rows}, Path("r"))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    (head,) = [words(line, "┃") for line in lines if "┃" in line]
    assert head == ["k", "worst motor [mrad]", "tool RMS [µm]", "tool maximum [µm]", "% of k = 0"]
    printed = [words(line, "│") for line in lines if "│" in line]
    made = [
        (row["k"], 1e3 * max(row["motor_inf"]), 1e6 * row["arm_rms"], 1e6 * row["arm_maxdev"])
        for row in summary["iterations"]
    ]
    of_first = [100.0 * row[2] / made[0][2] for row in made]
    expected = [[*map(cell, row), cell(float(c))] for row, c in zip(made, of_first, strict=True)]
    expected[-1][1] = cell(None) if without else expected[-1][1]
    assert printed == expected


def words(line: str, bar: str) -> list[str]:
    return [cell.strip() for cell in line.strip(bar).split(bar)]


def test_two_processes_write_the_same_bits(summary, folder, tmp_path):
    command = [sys.executable, "-m", "armside.scripts.cli", "laser", "--quiet", "--out", "again"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=120)
    first, again = folder, tmp_path / "again"
    assert json.loads((again / "summary.json").read_text())["iterations"] == summary["iterations"]
    signals = [read_signals(f / "signals.parquet").runs for f in (first, again)]
    for a, b in zip(*signals, strict=True):
        assert np.array_equal(a.recording.motor_angle, b.recording.motor_angle)
        assert np.array_equal(a.recording.correction, b.recording.correction)
        assert np.array_equal(a.recording.truth.qpos, b.recording.truth.qpos)
        assert np.array_equal(a.tracker.position, b.tracker.position)
    # identifiers differ, and with them the bytes of the files
    replays = [f / "replay.rrd" for f in (first, again)]
    assert content(replays[0]) == content(replays[1])


def test_a_run_that_diverges_stops_with_what_it_has(tmp_path, capsys):
    assert (
        main(["laser", "--gamma", "3", "--iterations", "20", "--quiet", "--out", str(tmp_path)])
        == 1
    )
    assert "diverged" in capsys.readouterr().err
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "diverged"
    assert 1 < len(summary["iterations"]) < 21


def test_limits_that_were_hit_are_listed_and_said(tmp_path, capsys):
    args = ["laser", "--speed", "100", "--iterations", "0", "--out", str(tmp_path)]
    assert main(args) == 0
    (line,) = [x for x in capsys.readouterr().out.splitlines() if x.startswith("Note: ")]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert [hit["limit"] for hit in summary["limits_hit"]] == ["centripetal_acceleration"]
    (note,) = summary["notes"]
    assert (note["cause"], note["runs"]) == ("speed", [])
    assert line == f"Note: {note['text']}"
    assert summary["reached_speed"] == pytest.approx(np.sqrt(1.3 * 0.005))


def test_six_values_make_a_law_per_motor(tmp_path):
    found = ran(tmp_path, "laser --gamma 0.9 0.9 0.9 0.9 0.9 0.5 --iterations 1")
    assert found["config"]["gamma"] == [0.9, 0.9, 0.9, 0.9, 0.9, 0.5]


def test_a_model_that_lacks_a_joint_is_refused_by_name(tmp_path, bad_input):
    text = assets.LARGE_ROBOT_XML.read_text().replace('"motor_5"', '"engine_5"')
    (tmp_path / "robot.xml").write_text(text)
    bad_input("laser --model robot.xml", "motor_5")


FOUND = {"arm_rms": 2e-6, "interval": [1e-6, 3e-6], "uncorrected": 1e-4, "trusted": True}


@pytest.mark.parametrize(
    ("changes", "first", "said"),
    [
        ({}, None, "by the twin: not measured, 100 um without correction; predicted 2.0 um, 1.0"),
        ({}, 2.5e-6, "2.5 um, 100 um without correction; predicted 2.0 um, 1.0 to 3.0 um (90 %)"),
        ({"trusted": False}, 1.2e-4, "First cut without correction: 120.0 um, 100 um by the twin"),
        ({"interval": None}, 2.5e-6, "predicted 2.0 um, of unknown accuracy"),
    ],
)
def test_the_line_has_the_interval_and_its_rate_where_they_are_known(changes, first, said):
    text = line(FOUND | changes, [{"arm_rms": first}])
    assert said in text
    assert text.endswith("(90 %)") is (not changes)
