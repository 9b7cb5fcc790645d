"""The examples of the docs run as they stand, and do what they say."""

import runpy
from pathlib import Path

import pytest

from armside.scripts import cli

EXAMPLES = Path(__file__).parent.parent / "docs" / "examples"


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def example(name):
    return runpy.run_path(str(EXAMPLES / name), run_name="__main__")


def test_there_are_no_examples_that_nobody_runs():
    assert {f.name for f in EXAMPLES.iterdir() if f.suffix in (".py", ".toml")} == {
        "adjoint.py",
        "composed_laws.py",
        "own_law.py",
        "laws.py",
        "own_data.py",
        "own_robot.py",
        "own_path.py",
        "house.toml",
        "swing.toml",
    }


def test_a_law_of_ten_lines_learns():
    rms = example("own_law.py")["rms"]
    assert rms[-1] < 0.7 * rms[0]


def test_own_data_are_measured_and_the_command_agrees(capsys):
    measured = example("own_data.py")["measured"]
    assert measured.arm_rms == pytest.approx(20e-6, rel=1e-6)
    assert list(measured.motor_inf) == pytest.approx([0.1, 0.1])
    assert cli.main(["measure", "mine.csv", "--gear", "100", "50", "--radius", "5"]) == 0
    assert " 20 " in capsys.readouterr().out


def test_a_robot_of_ones_own_is_cut_with_and_learns():
    rms = example("own_robot.py")["rms"]
    assert rms[-1] < rms[0]


def test_contours_of_ones_own_come_from_points_drawings_and_python():
    made = example("own_path.py")
    assert made["house"].length == pytest.approx(2 * 0.012 + 0.02 + 2 * 0.01044, rel=0.1)


def test_a_contour_of_ones_own_is_cut_from_the_command_line_and_replayed():
    words = ["laser", "--contour", str(EXAMPLES / "house.toml"), "--speed", "30"]
    assert cli.main([*words, "--iterations", "0", "--quiet", "--out", "house"]) == 0
    assert cli.main(["replay", "house", "--save", "house.rrd", "--quiet"]) == 0


def test_a_contour_and_a_radius_exclude_each_other(capsys):
    words = ["laser", "--contour", str(EXAMPLES / "house.toml"), "--radius", "3"]
    assert cli.main(words) == 2
    assert "contour from a file has no radius" in capsys.readouterr().err
