"""`armside export RUN`: the last correction alone, for a controller or another program."""

import json
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armside import kinematics
from armside.ilc.workbench.compare import read_states, save_states
from armside.scripts.cli import main
from armside.scripts.cutting.earlier import KEY, STATE
from armside.sim.cell import LARGE_CELL
from armside.sim.controller.stored_correction import read_correction
from armside.sim.records import read_run
from armside.sim.records.tables import read_table, units

from .ran import ran

ROBOT = "large:radius=2,speed=40"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A run of laser, and one of learn with two laws on the same cut."""
    folder = tmp_path_factory.mktemp("export")
    ran(folder / "cut", "laser --radius 2 --speed 40 --iterations 1")
    ran(folder / "two", f"learn --plant {ROBOT} --laws heuristic gradient --iterations 1")
    return folder


@pytest.fixture
def export(place, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)

    def run(name: str, *words: str) -> int:
        return main(["export", str(place / name), *words, "--quiet"])

    return run


@pytest.fixture
def last(place):
    return read_run(place / "cut").signals.runs[-1].recording


def columns(file, prefix="correction"):
    table = read_table(Path(file))
    names = [name for name in table.column_names if name.startswith(prefix)]
    return np.column_stack([table[name].to_numpy() for name in names])


@pytest.mark.parametrize("kind", ["csv", "mat", "parquet"])
def test_the_last_correction_is_written_bit_for_bit_and_nothing_else(kind, export, last):
    assert export("cut", "--to", kind) == 0
    table = read_table(Path(f"joint-correction.{kind}"))
    assert table.column_names == ["time", *(f"correction_{i}" for i in range(1, 7))]
    assert set(units(table).values()) == {"s", "rad"}
    np.testing.assert_array_equal(columns(f"joint-correction.{kind}"), last.correction)


def test_a_joint_path_is_reference_and_correction(export, last):
    assert export("cut", "--what", "joint-path") == 0
    np.testing.assert_array_equal(
        columns("joint-path.csv", "joint"), last.reference + last.correction
    )


def test_a_tool_path_is_the_pose_of_the_corrected_reference(export, last):
    assert export("cut", "--what", "tool-path", "--rate", "1000") == 0
    found = columns("tool-path.csv", "tool")
    T = kinematics.compile(LARGE_CELL.robot).pose(last.reference + last.correction)
    np.testing.assert_allclose(found[::4, :3], T[:, :3, 3], rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(found[:, 3:], axis=1), 1.0, rtol=1e-12)


def test_rsi_messages_hold_the_correction_in_degrees(export, last):
    assert export("cut", "--to", "rsi") == 0
    lines = [ET.fromstring(line) for line in Path("joint-correction.rsi").read_text().splitlines()]
    axes = [line.findall("AKorr")[0].attrib for line in lines]
    said = [[float(axis[f"A{i}"]) for i in range(1, 7)] for axis in axes]
    np.testing.assert_array_equal(said, np.rad2deg(last.correction))
    clock = 1e-3 * np.array([float(line.findtext("IPOC")) for line in lines])
    np.testing.assert_allclose(clock, last.time - last.time[0], rtol=0, atol=1e-9)


def test_egm_messages_hold_the_joint_path_in_degrees(export, last):
    from armside.sim.controller.egm import _messages

    assert export("cut", "--what", "joint-path", "--to", "egm") == 0
    kind, data, found = _messages()[1], Path("joint-path.egm").read_bytes(), []
    clock = []
    while data:
        size, data = data[0], data[1:]  # below 128: one byte of varint
        message, data = kind.FromString(data[:size]), data[size:]
        found.append(list(message.planned.joints.joints))
        clock.append((message.header.seqno, message.header.tm))
    np.testing.assert_array_equal(found, np.rad2deg(last.reference + last.correction))
    assert clock == [(1 + i, 4 * i) for i in range(len(last.time))]


def test_learning_starts_from_a_correction_in_a_file(export, place, capsys):
    assert export("two", "--law", "gradient", "--to", "mat", "--beyond", "worse") == 0
    words = ["learn", "--plant", ROBOT, "--from", "joint-correction.mat", "--iterations", "0"]
    assert main([*words, "--out", "more"]) == 0
    assert "Starts from the correction of joint-correction.mat" in capsys.readouterr().out
    more = json.loads(Path("more/summary.json").read_text())
    before = json.loads((place / "two" / "summary.json").read_text())
    assert more["started_from"]["run"] == "joint-correction.mat"
    gradient = before["laws"][1]["error_two"]
    assert more["laws"][0]["error_two"][0] == pytest.approx(gradient[1], rel=0.05)
    assert more["laws"][0]["error_two"][0] < 0.6 * gradient[0]
    sent = read_correction(Path("joint-correction.mat")).values
    np.testing.assert_array_equal(columns("more/correction-1-heuristic.csv", "u"), sent)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["two"], "has several laws, give one: heuristic, gradient"),
        (["two", "--law", "splines"], "has no law 'splines'"),
        (["cut", "--to", "rsi", "--rate", "500"], "rsi has 250 Hz"),
        (["cut", "--to", "egm"], "give --what joint-path"),
        (["cut", "--rate", "1e9"], "rate must be 1 to 20000 Hz"),
        (["cut", "--file", "a.mat"], "csv files end with .csv"),
        (["none"], "is no folder"),
        (
            ["cut", "--to", "c"],
            "--to of a run is csv, mat, parquet, rsi, egm, got c: leave the run out",
        ),
        (["cut", "--what", "pose"], "--what of a run is joint-correction, joint-path, tool-path"),
    ],
)
def test_bad_input_is_one_line(bad_input, words, said, place):
    bad_input(f"export {place / words[0]} {' '.join(words[1:])}", said)


@pytest.fixture(scope="module")
def wild(place):
    """A run whose stored correction was a million radians, repeated: six hard stops, no beam."""
    changed = place / "changed"
    shutil.copytree(place / "cut", changed)
    state = read_states(changed / STATE)[KEY]
    loop = replace(state.loop, correction=np.full_like(state.loop.correction, 1e6))
    save_states(changed / STATE, {KEY: replace(state, loop=loop)})
    words = ["--iterations", "0", "--quiet", "--out", str(place / "wild")]
    assert main(["laser", "--from", str(changed), *words]) == 1
    return place / "wild"


def test_a_run_that_ended_in_its_hard_stops_is_not_done(wild):
    assert json.loads((wild / "summary.json").read_text())["status"] == "saturated"


BEYOND = ("saturated", "beam", "size", "speed", "acceleration", "range")


@pytest.mark.parametrize(
    "words", ["--to rsi", "--to egm --what joint-path", "--to csv", "--what tool-path --to mat"]
)
def test_no_form_lets_a_correction_to_a_robot_that_exceeds_the_gate(wild, bad_input, words):
    said = bad_input(f"export {wild} {words}", f"beyond {' '.join(BEYOND)} lets it through")
    assert "got 5.72958e+07. Held back from robots" in said


def test_what_is_let_through_by_its_name_says_so_in_the_file(wild, export):
    assert export("wild", "--to", "rsi", "--beyond", *BEYOND[1:]) == 2
    assert export("wild", "--to", "rsi", "--beyond", *BEYOND) == 0
    lines = Path("joint-correction.rsi").read_text().splitlines()
    assert [line.split(":")[0] for line in lines[: len(BEYOND)]] == [
        f"<!-- beyond {name}" for name in BEYOND
    ]
    assert "AKorr" in lines[len(BEYOND)]
    for kind in ("csv", "mat", "parquet"):
        assert export("wild", "--to", kind, "--beyond", *BEYOND) == 0
        about = read_table(Path(f"joint-correction.{kind}")).schema.metadata
        said = json.loads(about[b"armside.beyond"])
        assert [line.split(":")[0] for line in said] == [f"beyond {name}" for name in BEYOND]


@pytest.mark.parametrize("name", ["worse", "diverged"])
def test_a_run_that_ended_badly_is_held_back(name, place, export, capsys):
    """Of the two laws one, in its stored table."""
    file = place / "two" / "summary.json"
    before = json.loads(file.read_text())
    grown = [1e-4, 2e-4 if name == "worse" else 1e-4]
    changed = {"arm_rms": grown, "diverged": name == "diverged"}
    laws = [before["laws"][0], before["laws"][1] | changed]
    try:
        file.write_text(json.dumps(before | {"laws": laws}))
        assert export("two", "--law", "heuristic") == 0
        assert export("two", "--law", "gradient") == 2
        assert f"beyond {name} lets it through" in capsys.readouterr().err
        assert export("two", "--law", "gradient", "--beyond", name) == 0
    finally:
        file.write_text(json.dumps(before))
