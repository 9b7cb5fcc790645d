"""`armside program read`, `armside cut --as-program` and `armside export RUN --into`."""

import json

import pytest

from armside.scripts.cli import main
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


def test_export_into_a_program_is_what_cut_writes(place, capsys):
    before, corrected = place / "plan/armside.mod", place / "run/armside.mod"
    assert main(["export", str(place / "run"), "--into", str(before), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    written = before.with_name("armside-corrected.mod")
    assert written.read_bytes() == corrected.read_bytes() != before.read_bytes()
    assert found["changed"] == found["targets"] > 10
    entry = json.loads((place / "run/summary.json").read_text(encoding="utf-8"))["program"]
    assert entry["largest_offset"] == found["largest_offset"]
    assert 1e-4 < entry["largest_offset"] < 3e-3
    assert entry["spacing"] == 0.0015
    (row,) = rows_of(read_program_file(written))
    assert entry["blocks_per_second"] == pytest.approx(0.1 / row.spacing[1:].min(), rel=0.2)


def test_a_correction_beyond_the_gate_enters_no_program(place, monkeypatch, tmp_path, capsys):
    """Gate of a tenth of a milliradian, in place of 5 degrees."""
    monkeypatch.setitem(gate.LIMITS, "size", (1e-4, 1e-4))
    before, file = place / "plan/armside.mod", tmp_path / "a.mod"
    words = ["export", str(place / "run"), "--into", str(before), "--file", str(file)]
    assert main(words) == 2
    assert "size: the correction of axis" in capsys.readouterr().err
    assert not file.exists()
    assert main([*words, "--beyond", "size", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["notes"][0].startswith("beyond size: ")
    cut = ["cut", str(place / "hole.svg"), "--speed", "100", "--as-program", "rapid", "--quiet"]
    learn = ["--spacing", "1.5", "--iterations", "1", "--measure", "tracker"]
    assert main([*cut, *learn, "--json", "--out", str(tmp_path / "held")]) == 0
    assert (tmp_path / "held/armside.mod").read_bytes() == before.read_bytes()
    assert json.loads(capsys.readouterr().out)["program"]["largest_offset"] == 0.0


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
