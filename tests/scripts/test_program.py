"""`armside program read`, `armside cut --as-program` and `armside export RUN --into`."""

import json
import shutil

import numpy as np
import pytest
from scipy.spatial import KDTree

from armside.scripts.cli import main
from armside.scripts.cutting import part_program
from armside.sim.controller import gate
from armside.sim.controller.programs import read_program_file, rows_of

HOLE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
<circle cx="20" cy="20" r="3.1" fill="none" stroke="black"/></svg>"""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A part that was cut twice, with its corrected program; and its program before."""
    pytest.importorskip("svgelements")
    folder = tmp_path_factory.mktemp("program")
    (folder / "hole.svg").write_text(HOLE, encoding="utf-8")
    cut = ["cut", str(folder / "hole.svg"), "--speed", "100", "--quiet", "--as-program", "rapid"]
    cut += ["--spacing", "1.5"]
    learn = ["--iterations", "1", "--measure", "tracker"]
    assert main([*cut, *learn, "--out", str(folder / "run")]) == 0
    assert main([*cut, "--plan-only", "--out", str(folder / "plan")]) == 0
    return folder


def paths(file):
    (row,) = rows_of(read_program_file(file))
    w = row.samples()
    return row.path(w[w > 2.0])  # without the way to the contour


def test_export_into_a_program_follows_the_targets_that_were_learned(place, capsys):
    """Of a fresh program of the same contour: but for the chord error of either."""
    before, corrected = place / "plan/armside.mod", place / "run/armside.mod"
    assert main(["export", str(place / "run"), "--into", str(before), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    written = before.with_name("armside-corrected.mod")
    assert found["changed"] == found["targets"] > 10
    away = KDTree(paths(written)).query(paths(corrected))[0]
    chord = json.loads((place / "plan/summary.json").read_text(encoding="utf-8"))["program"]
    assert np.median(away) < chord["chord_error"] < 1e-4
    assert np.median(KDTree(paths(before)).query(paths(written))[0]) > 3e-4
    summary = json.loads((place / "run/summary.json").read_text(encoding="utf-8"))
    entry, rows = summary["program"], summary["iterations"]
    assert rows[1]["arm_rms_true"] < 0.3 * rows[0]["arm_rms_true"]
    assert entry["largest_offset"] == pytest.approx(found["largest_offset"], rel=0.1)
    assert 1e-4 < entry["largest_offset"] < 3e-3
    assert entry["spacing"] == 0.0015
    (row,) = rows_of(read_program_file(corrected))
    assert entry["blocks_per_second"] == pytest.approx(0.1 / row.spacing.min(), rel=1e-3)


def test_targets_that_move_too_far_are_held_back_with_a_note(place, monkeypatch, tmp_path, capsys):
    """Bound of a tenth of a millimetre, in place of 5 mm."""
    monkeypatch.setattr(part_program, "LARGEST_OFFSET", 1e-4)
    cut = ["cut", str(place / "hole.svg"), "--speed", "100", "--as-program", "rapid", "--quiet"]
    learn = ["--spacing", "1.5", "--iterations", "1", "--measure", "tracker"]
    assert main([*cut, *learn, "--json", "--out", str(tmp_path / "held")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["program"]["largest_offset"] == 0.0
    (note,) = (note for note in found["notes"] if note["cause"] == "program")
    assert "at most 0.1 mm are allowed: the program is not corrected" in note["text"]
    before = place / "plan/armside.mod"
    assert (tmp_path / "held/armside.mod").read_bytes() == before.read_bytes()


def test_a_program_is_gone_on_from_and_samples_of_motors_are_not(place, samples, tmp_path, capsys):
    """Run k = 2 of one loop and of two are the same."""
    start, out = str(place / "run"), str(tmp_path / "more")
    learn = ["--iterations", "1", "--json", "--quiet"]
    assert main(["cut", "--from", start, *learn, "--out", out]) == 0
    rows = json.loads(capsys.readouterr().out)["iterations"]
    assert [row["k"] for row in rows] == [0, 2]
    stored = json.loads((place / "run/summary.json").read_text(encoding="utf-8"))
    assert rows[0]["arm_rms"] == stored["iterations"][0]["arm_rms"]
    words = ["cut", "--from", samples, "--as-program", "krl"]
    words += ["--out", str(tmp_path / "other")]
    assert main(words) == 2
    assert "start from a run with --as-program" in capsys.readouterr().err
    assert main(["export", start, "--to", "csv", "--file", str(tmp_path / "u.csv")]) == 2
    assert "in the targets of its program" in capsys.readouterr().err


@pytest.fixture(scope="module")
def samples(place):
    """The same part, learned once by samples of the motors."""
    cut = ["cut", str(place / "hole.svg"), "--speed", "100", "--iterations", "1", "--quiet"]
    assert main([*cut, "--measure", "tracker", "--out", str(place / "samples")]) == 0
    return str(place / "samples")


def test_a_correction_beyond_the_gate_enters_no_program(samples, place, monkeypatch, capsys):
    """Gate of a tenth of a milliradian, in place of 5 degrees."""
    monkeypatch.setitem(gate.LIMITS, "size", (1e-4, 1e-4))
    file = place / "gated.mod"
    words = ["export", samples, "--into", str(place / "plan/armside.mod"), "--file", str(file)]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert "size: the correction of axis" in error
    assert error.count("\n") == 1
    assert not file.exists()
    assert main([*words, "--beyond", "size", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"][0].startswith("beyond size: ")
    assert file.exists()


ENDED = {
    "diverged": {"status": "diverged"},
    "saturated": {"status": "saturated"},
    "worse": {"status": "worse"},
    "beam": {"notes": [{"cause": "beam", "text": "the beam was lost", "runs": [1]}]},
}


@pytest.mark.parametrize("name", ENDED)
def test_targets_of_a_run_that_ended_badly_are_held_back(name, place, tmp_path, capsys):
    """By the name of its end, which a stored summary is given."""
    run = tmp_path / "run"
    shutil.copytree(place / "run", run)
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8")) | ENDED[name]
    (run / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    file = tmp_path / "a.mod"
    words = ["export", str(run), "--into", str(place / "plan/armside.mod"), "--file", str(file)]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert f"beyond {name} lets it through" in error
    assert error.count("\n") == 1
    assert not file.exists()
    assert main([*words, "--beyond", name, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"][0].startswith(f"beyond {name}: ")


def test_the_persons_program_is_never_written_over(place, capsys):
    file = place / "plan/armside.mod"
    before = file.read_bytes()
    words = ["export", str(place / "run"), "--into", str(file), "--file", str(file)]
    assert main(words) == 2
    assert "is the program itself" in capsys.readouterr().err
    assert file.read_bytes() == before


def test_read_describes_rows_in_si(place, capsys):
    assert main(["program", "read", str(place / "plan/armside.mod"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (row,) = found["rows"]
    assert found["moves"] == {"MoveL": row["targets"] - 1, "MoveC": 0, "MoveJ": 1}
    assert row["zones"][1] == pytest.approx(0.00075)
    assert row["speeds"] == [0.1, 0.1, 0.2]
    assert found["frames"] == {"tool": {"tool0": True}, "base": {"wobj0": True}}


REFUSED = [
    (["program", "read", "loop.src"], "line 2, column 1: loop is not understood"),
    (["program", "read", "part.nc"], "programs end with .mod, .src, .script"),
    (["export", "RUN", "--into", "loop.src"], "line 2, column 1: loop"),
    (["export", "RUN", "--into", "far.src"], "no linear moves within 1 mm of the run's path"),
    (["export", "RUN", "--into", "far.src", "--to", "csv"], "--to is not for --into"),
    (["export", "RUN", "--into", "far.src", "--file", "a.mod"], "--file must end with .src"),
    (["export", "--into", "far.src"], "--into is of a run"),
    (["cut", "hole.svg", "--spacing", "2"], "spacing is of --as-program"),
    (["cut", "hole.svg", "--as-program", "krl", "--spacing", "0.05"], "0.1 to 100 mm"),
]


@pytest.mark.parametrize(("words", "reason"), REFUSED)
def test_refused_in_one_line(words, reason, place, capsys, monkeypatch):
    monkeypatch.chdir(place)
    moves = [f"LIN {{X {x},Y 0,Z 0,A 0,B 0,C 0}}" for x in (1, 2)]
    head = "$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$VEL.CP=1\n"
    files = {"loop.src": "DEF m( )\nLOOP\nENDLOOP\nEND\n", "part.nc": "G1 X1"}
    files["far.src"] = f"DEF m( )\n{head}{moves[0]}\n{moves[1]}\nEND\n"
    for name, text in files.items():
        (place / name).write_text(text, encoding="utf-8")
    assert main([str(place / "run") if word == "RUN" else word for word in words]) == 2
    error = capsys.readouterr().err
    assert reason in error
    assert error.count("\n") == 1
