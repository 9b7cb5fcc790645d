"""`armside measure` on contours, any number of motors, and data that lack something."""

import json

import numpy as np
import pytest

from armside.scripts import cli
from armside.sim.part.contour_file import read_contour

HOUSE = "corner = 1.5\npoints = [[-10, -6], [10, -6], [10, 6], [0, 9], [-10, 6]]\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "house.toml").write_text(HOUSE)
    return tmp_path


def write(file, **columns):
    rows = np.column_stack(list(columns.values()))
    np.savetxt(file, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.15g")


def turn(place, outwards=0.0, turned=0.0, n=400):
    """Points around the house, displaced outwards [m], then turned and moved, in space."""
    curve = read_contour(place / "house.toml")
    s = np.arange(n) * curve.length / n
    tangent = curve.tangent(s)
    flat = curve.point(s) + outwards * np.column_stack([tangent[:, 1], -tangent[:, 0]])
    c, si = np.cos(turned), np.sin(turned)
    flat = flat @ np.array([[c, si], [-si, c]]) + [0.7, -0.2]
    names = ("tracker_x", "tracker_y", "tracker_z")
    return dict(zip(names, (*flat.T, np.full(n, 1.1)), strict=True))


def motors(n_motors, n=400):
    time = np.arange(n) * 0.004
    found = {"time": time}
    for i in range(1, n_motors + 1):
        found[f"reference_{i}"] = np.sin(i * time)
        found[f"motor_angle_{i}"] = np.sin(i * time) - 1e-4 * i
    return found


def measured(capsys, *words):
    assert cli.main(["measure", *words, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["iterations"]
    return row


@pytest.mark.parametrize(("angle", "option"), [(0.1, "0"), (1.2, "75"), (-3.0, "-170")])
def test_a_contour_is_judged_wherever_it_lies(place, capsys, angle, option):
    write("a.csv", **motors(2), **turn(place, turned=angle))
    words = ["a.csv", "--gear", "1", "1", "--contour", "house.toml", "--turned", option]
    row = measured(capsys, *words)
    assert row["arm_maxdev"] < 1e-9


def test_a_contour_cut_too_large_is_off_by_that_much(place, capsys):
    """Edges 30 um outwards on all sides: the best fit leaves that distance."""
    write("a.csv", **motors(1), **turn(place, outwards=30e-6, turned=0.05))
    row = measured(capsys, "a.csv", "--gear", "1", "--contour", "house.toml")
    assert row["arm_rms"] == pytest.approx(30e-6, rel=0.02)
    assert row["arm_maxdev"] == pytest.approx(30e-6, rel=0.1)


@pytest.mark.parametrize("n_motors", [1, 7, 9])
def test_any_number_of_motors_is_measured_and_no_tool_is_shown(place, capsys, n_motors):
    write("a.csv", **motors(n_motors))
    assert cli.main(["measure", "a.csv", "--gear", *["2"] * n_motors]) == 0
    table = capsys.readouterr().out
    assert f"motor {n_motors}" in table
    assert "Not measured: the tool" in table
    assert "nan" not in table
    assert "arm RMS" not in table


def test_a_tracker_alone_is_measured_without_motors(place, capsys):
    write("a.csv", time=motors(1)["time"], **turn(place, outwards=30e-6))
    assert cli.main(["measure", "a.csv", "--contour", "house.toml"]) == 0
    table = capsys.readouterr().out
    assert "motor" not in table
    assert "arm RMS" in table


def test_a_motor_without_samples_is_left_out_by_name(place, capsys):
    write("a.csv", **{**motors(1), "motor_angle_1": np.full(400, np.nan)}, **turn(place))
    assert cli.main(["measure", "a.csv", "--gear", "1", "--contour", "house.toml"]) == 0
    table = capsys.readouterr().out
    assert "Not measured: motor 1, without samples" in table
    assert "nan" not in table


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--contour house.toml --radius 5", "not both"),
        ("--contour none.toml", "none.toml"),
        ("--turned 400", "turned must be"),
        ("", "columns are missing"),
    ],
)
def test_bad_input_is_one_line(place, bad_input, words, said):
    write("a.csv", time=motors(1)["time"], **turn(place))
    bad_input(f"measure a.csv {words}", said)
