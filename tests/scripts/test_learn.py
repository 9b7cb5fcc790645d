"""`armside learn`: comparisons, continuations, plants by hand, and its errors."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from armside.ilc.models.conversion import as_state_space
from armside.ilc.models.file import write_model
from armside.ilc.models.system import System
from armside.ilc.models.system_matrix import SystemMatrix
from armside.scripts.cli import main
from armside.scripts.workbench.law_results import of_the_tool
from armside.sim.notes import GROWTH

from .ran import ran

LAG = {"sample_time": 0.01, "b": [0, 0.1], "a": [1, -0.9]}
OWN = """
import math

def half(u, e):
    return u + 0.5 * e

def broken(u, e):
    return u + e["all"]
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lag.json").write_text(json.dumps(LAG))
    (tmp_path / "own.py").write_text(OWN)
    return tmp_path


def read(folder):
    return json.loads((folder / "summary.json").read_text())


SIX = ("heuristic:gamma=0.5,delta=1", "gradient", "inverse", "norm-optimal", "high-order")


@pytest.mark.parametrize("plant", ["lag.json", "two-mass"])
def test_six_laws_on_a_plant_in_one_table_of_80_columns(plant, place, capsys):
    words = ["learn", "--plant", plant, "--laws", *SIX, "own.py:half", "--iterations", "1"]
    assert main([*words, "--samples", "80", "--out", "a"]) == 0
    table = capsys.readouterr().out
    assert max(map(len, table.splitlines())) <= 80
    for law in ("heuristic", *SIX[1:], "own.py"):
        assert law in table
    found = read(place / "a")["laws"]
    assert len(found) == 6
    assert all(len(each["predicted"]["error_two"]) == 2 for each in found)
    assert (place / "a" / "convergence.png").stat().st_size > 10_000
    assert len(list((place / "a").glob("correction-*.csv"))) == 6


def test_coupled_motors_show_their_eigenloci_below_the_criterion(place, capsys):
    servo = System(np.array([0, 0.1]), np.array([1, -0.9]), 0.01)
    write_model(place / "two.json", as_state_space(SystemMatrix(
        ((servo, servo * 0.5), (servo * 0.0, servo)))))  # fmt: skip
    laws = ["heuristic:gamma=0.5,delta=1", "norm-optimal"]
    words = ["learn", "--plant", "two.json", "--laws", *laws, "--iterations", "1"]
    assert main([*words, "--samples", "80", "--out", "a"]) == 0
    assert f"Eigenloci of {laws[0]}: largest modulus" in capsys.readouterr().out
    found = read(place / "a")
    (entry,) = found["eigenloci"].values()
    criterion = found["laws"][0]["predicted"]["criterion"]
    assert 0.0 < entry["largest"] <= entry["bound"] < criterion  # not normal
    assert [file.name for file in (place / "a").glob("eigenloci*")] == ["eigenloci-1.png"]


def test_laws_of_noise_points_laps_and_bases_are_predicted_beside_their_results(place):
    laws = ("knob-free", "basis:order=2", "rational", "point-to-point:times=0.3/0.6")
    laws += ("kalman:noise=0.01", "repetitive:period=30", "h-infinity:uncertainty=0.3")
    line = "learn --plant lag.json --iterations 1 --samples 100 --laws"
    found = ran(place / "a", line, *laws)["laws"]
    assert [each["law"] for each in found] == list(laws)
    for each in found:
        assert not each["diverged"]
        assert each["predicted"]["error_two"] == pytest.approx(each["error_two"], rel=1e-6)


def test_a_robot_goes_on_bit_for_bit_and_says_so(place):
    robot = "learn --plant large:radius=2,speed=80 --seed 4"
    two = ran(place / "two", robot, "--iterations 2")
    ran(place / "one", robot, "--iterations 1")
    more = ran(place / "more", "learn --from one --iterations 1")
    assert more["started_from"]["how"] == "its last runs"
    assert more["laws"][0]["error_two"] == two["laws"][0]["error_two"][2:]
    assert more["laws"][0]["arm_rms"] == two["laws"][0]["arm_rms"][2:]


def test_motors_that_follow_while_the_tool_gets_worse_are_noted(place, capsys):
    words = ["learn", "--plant", "large:radius=2,speed=80", "--iterations", "1"]
    assert main([*words, "--out", "one"]) == 0
    said, (law,) = capsys.readouterr().out, read(place / "one")["laws"]
    assert law["error_two"][1] < law["error_two"][0]
    first, last = (1e6 * rms for rms in law["arm_rms"])
    assert last > first
    rms = f"RMS {first:.4g} to {last:.4g} um with heuristic"
    assert read(place / "one")["notes"] == [f"1 of 1 runs made the tool worse: {rms}"]
    assert "arm RMS [µm], k = 0" in said
    assert f"{last:.4g}" in said
    assert main(["learn", "--from", "one", "--iterations", "1", "--out", "more"]) == 0
    heads = [line for line in capsys.readouterr().out.splitlines() if "law" in line]
    assert [line.count("k = 2") for line in heads] == [1, 1]  # one run, one column


def test_another_law_starts_from_the_correction(place):
    first = ran(place / "a", "learn --plant lag.json --laws gradient --iterations 3")
    then = ran(place / "b", "learn --from a --laws own.py:half --iterations 1")
    assert then["started_from"]["changed"] == ["laws"]
    assert then["laws"][0]["error_two"][0] == first["laws"][0]["error_two"][-1]


def test_a_folder_asks_for_each_log_and_ends_with_the_results(place, capsys):
    hand = place / "hand"
    hand.mkdir()
    rows = "\n".join(f"{i / 100!r},{min(i / 20, 1.0)!r}" for i in range(40))
    (hand / "reference.csv").write_text("time,r\n" + rows)
    words = ["learn", "--plant", "hand", "--laws", "own.py:half", "--iterations", "1"]
    for k in range(2):
        assert main([*words, "--out", "a"]) == 0
        assert f"u_{k}.csv" in capsys.readouterr().out
        assert not (place / "a").exists()
        u = np.loadtxt(hand / f"u_{k}.csv", delimiter=",", skiprows=1)
        np.savetxt(hand / f"y_{k}.csv", u, delimiter=",")
        (hand / f"y_{k}.csv").write_text("time,y\n" + (hand / f"y_{k}.csv").read_text())
    assert main([*words, "--out", "a"]) == 0
    assert len(read(place / "a")["laws"][0]["error_two"]) == 2


def test_results_kept_under_the_name_of_a_plant_do_not_become_the_plant(place):
    ran(place / "two-mass", "learn --iterations 0")
    assert len(ran(place / "again", "learn --iterations 0 --plant two-mass")["laws"]) == 1
    assert not (place / "two-mass" / "u_0.csv").exists()


def test_a_correction_is_carried_over_to_another_speed_but_not_to_another_path(place, capsys):
    ran(place / "slow", "learn --plant large:radius=2,speed=60 --iterations 2")
    line = "learn --plant large:radius=2,speed=70 --iterations 0"
    without, carried = ran(place / "without", line), ran(place / "carried", line, "--from slow")
    assert carried["started_from"]["changed"] == ["plant"]
    assert carried["laws"][0]["error_two"][0] < 0.5 * without["laws"][0]["error_two"][0]
    for plant, other in (("large:radius=3", "radius"), ("large:radius=2,pose=p2", "pose")):
        assert main(["learn", "--plant", plant, "--from", "slow", "--out", "other"]) == 2
        said = capsys.readouterr().err
        assert f"another {other}, and a correction belongs to its path" in said


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        ("--reference=", 2, "--reference= has an empty value"),
        ("--plant lag.jsn", 2, "Unknown plant 'lag.jsn'"),
        ("--plant lag.json --laws herustic", 2, "Unknown law 'herustic'"),
        (
            "--plant lag.json --laws own.py:third",
            2,
            "Unknown name 'third'. It can be: half, broken",
        ),
        ("--plant lag.json --laws own.py:broken", 1, "own.py, line 8: IndexError"),
        ("--plant lag.json --laws heuristic:gamma=30,cutoff=40", 1, "diverged with heuristic"),
        ("--plant lag.json --laws repetitive:period=2", 2, "a lap of 2 samples is too short"),
        ("--plant lag.json --laws repetitive:period=300", 2, "two laps of 300, got 400"),
        ("--plant large:pose=p9", 2, "p9"),
        ("--plant large --reference step", 2, "a robot's reference is its cut"),
        ("--plant lag.json --model own.py", 2, "own.py is not a readable JSON"),
        ("--noise -1", 2, "noise must be"),
        ("--from nowhere", 2, "nowhere is no folder"),
        ("--plant .", 2, "no reference"),
        ("--plant lag.json --beyond size", 2, "beyond is of a controller, egm or rsi"),
    ],
)
def test_bad_input_and_failures_are_one_line(words, status, message, place, capsys):
    assert main(["learn", "--iterations", "2", *words.split(), "--out", "out"]) == status
    said = capsys.readouterr().err
    assert message in said
    assert len(said.splitlines()) == 1
    assert (place / "out").exists() == ("diverged" in message)


def test_a_tool_that_got_worse_by_more_than_a_twentieth_is_noted_in_micrometres():
    def run(law, *tool):
        return SimpleNamespace(law=law, measures=[{"arm_rms": rms} for rms in tool])

    runs = [run("a", 1e-4, 1.049e-4), run("b", 1e-4, 2e-4), run("c", 1e-4, 3e-5)]
    assert GROWTH == 1.05
    assert of_the_tool(runs) == ["1 of 3 runs made the tool worse: RMS 100 to 200 um with b"]
    assert of_the_tool([runs[0], runs[2]]) == []
