"""`armside laser` and `armside cut` go on from an earlier run, or take its correction elsewhere."""

import json

import ezdxf
import numpy as np
import pytest

from armside import assets
from armside.scripts.cli import main
from armside.sim.records import read_run

from .ran import ran

SCARA = str(assets.IRB1400_XML.parent / "scara.toml")


def drawing(folder):
    document = ezdxf.new(units=4)  # pyright: ignore[reportPrivateImportUsage]
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (40, 0), (40, 25), (0, 25)], close=True)
    space.add_circle((10, 12), 4.0)
    document.saveas(folder / "plate.dxf")
    return folder / "plate.dxf"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("from")


@pytest.fixture(scope="module")
def first(place):
    ran(place / "a", "laser", "--gamma", 0.8, "--seed", 3, "--iterations", 2)
    return place / "a"


@pytest.fixture(scope="module")
def part(place):
    words = ("--speed", 60, "--pose", "p2", "--iterations", 1)
    ran(place / "part", "cut", drawing(place), *words)
    return place / "part"


def corrections(folder):
    return {one.k: one.recording.correction for one in read_run(folder).signals.runs}


def test_updates_in_two_runs_are_those_of_one_to_the_last_bit(first, tmp_path):
    """Noise goes on; a third run goes on from the second."""
    options = ("--gamma", 0.8, "--seed", 3)
    once = ran(tmp_path / "once", "laser", *options, "--iterations", 4)
    ran(tmp_path / "b", "laser", "--from", first, "--iterations", 1)
    again = ran(tmp_path / "c", "laser", "--from", tmp_path / "b", "--iterations", 1)
    assert again["iterations"] == [once["iterations"][0], once["iterations"][4]]
    assert again["started_from"]["how"] == "its last run"
    whole, parts = corrections(tmp_path / "once"), corrections(tmp_path / "c")
    np.testing.assert_array_equal(parts[4], whole[4])


def test_a_part_goes_on_to_the_last_bit_without_its_drawing_being_named(part, place, tmp_path):
    words = ("--speed", 60, "--pose", "p2", "--iterations", 2)
    once = ran(tmp_path / "once", "cut", place / "plate.dxf", *words)
    again = ran(tmp_path / "b", "cut", "--from", part, "--iterations", 1)
    assert again["iterations"][-1] == once["iterations"][-1]
    for contour, whole in zip(again["contours"], once["contours"], strict=True):
        assert contour["iterations"][-1] == whole["iterations"][-1]


def test_a_correction_is_repeated_alone(first, tmp_path):
    again = ran(tmp_path / "b", "laser", "--from", first, "--iterations", 0)
    (row,) = again["iterations"]
    assert row["k"] == 0
    np.testing.assert_array_equal(corrections(tmp_path / "b")[0], corrections(first)[2])
    assert again["started_from"]["how"] == "its correction, repeated"


def test_another_payload_is_a_stated_test_of_transfer(first, tmp_path):
    carried = ran(tmp_path / "b", "laser", "--from", first, "--payload", 100, "--iterations", 0)
    said = carried["started_from"]
    assert said["changed"] == ["payload"]
    assert carried["config"]["gamma"] == [0.8]
    assert carried["config"]["seed"] == 3
    (row,) = carried["iterations"]
    for after, before in zip(row["motor_two"], said["uncorrected"]["motor_two"], strict=True):
        assert after < 0.4 * before


def test_a_part_is_taken_to_another_speed_by_the_place_on_its_path(part, tmp_path):
    carried = ran(tmp_path / "b", "cut", "--from", part, "--speed", 80, "--iterations", 0)
    said, (row,) = carried["started_from"], carried["iterations"]
    assert said["changed"] == ["speed"]
    assert sum(row["motor_two"]) < 0.8 * sum(said["uncorrected"]["motor_two"])


def test_a_correction_goes_axis_by_axis_to_another_robot_with_the_same_axes(first, tmp_path):
    """A stated test of transfer: its first run is shown beside one without the correction."""
    carried = ran(tmp_path / "b", "laser", "--from", first, "--robot", "irb1400", "--iterations", 0)
    assert carried["started_from"]["changed"] == ["robot", "delta", "cutoff"]  # a design of its own
    taken, learned = corrections(tmp_path / "b")[0], corrections(first)[2]
    assert taken.shape[1] == 6
    np.testing.assert_allclose(np.ptp(taken, axis=0), np.ptp(learned, axis=0), rtol=0.05)
    (row,) = carried["iterations"]
    assert row["motor_two"] != carried["started_from"]["uncorrected"]["motor_two"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--pose p2", "its tool path is another one"),
        ("--robot irb1400 --radius 6", "its contour is another one"),
        (f"--robot {SCARA}", "has 4 axes, axis 3 sliding: a correction goes to a robot with as"),
        ("--shape square --size 10", "its tool path is another one"),
    ],
)
def test_what_cannot_be_started_from_is_refused_in_one_line(words, said, first, bad_input):
    bad_input(f"laser --from {first} {words} --out x", said)


def test_a_run_of_another_command_or_that_diverged_is_no_start(part, first, tmp_path, capsys):
    assert main(["laser", "--from", str(part)]) == 2
    assert "is a run of cut, not of laser" in capsys.readouterr().err
    words = ["laser", "--iterations", "2", "--gamma", "8", "--quiet", "--out", str(tmp_path / "a")]
    assert main(words) == 1
    assert main(["laser", "--from", str(tmp_path / "a")]) == 2
    assert "ended with status diverged" in capsys.readouterr().err


def test_a_first_run_that_comes_out_otherwise_is_not_gone_on_from(first, tmp_path, capsys):
    """As after an update of the software: the state would be another loop's."""
    other = tmp_path / "other"
    other.mkdir()
    for file in first.iterdir():
        (other / file.name).write_bytes(file.read_bytes())
    summary = json.loads((other / "summary.json").read_text())
    summary["config"]["friction_spread"] = 2.5
    (other / "summary.json").write_text(json.dumps(summary))
    assert main(["laser", "--from", str(other), "--iterations", "1"]) == 2
    assert "its first run does not come out the same here" in capsys.readouterr().err
