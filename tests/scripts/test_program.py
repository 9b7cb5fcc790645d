"""`armside program read`, `armside cut --as-program` and `armside export RUN --into`."""

import json
import shutil

import numpy as np
import pytest
from scipy.spatial import KDTree

from armside.scripts.cutting import part_program
from armside.sim.controller import gate
from armside.sim.controller.programs import read_program_file, rows_of

from .ran import ran

HOLE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
<circle cx="20" cy="20" r="3.1" fill="none" stroke="black"/></svg>"""
CUT = "--speed 100 --as-program rapid --spacing 1.5"
LEARN = "--iterations 1 --measure tracker"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A part that was cut twice, with its corrected program; and its program before."""
    pytest.importorskip("svgelements")
    folder = tmp_path_factory.mktemp("program")
    (folder / "hole.svg").write_text(HOLE, encoding="utf-8")
    cut = f"cut {folder / 'hole.svg'} {CUT}"
    ran(folder / "run", cut, LEARN)
    ran(folder / "plan", cut, "--plan-only")
    return folder


def paths(file):
    (row,) = rows_of(read_program_file(file))
    w = row.samples()
    return row.path(w[w > 2.0])  # without the way to the contour


def test_export_into_a_program_follows_the_targets_that_were_learned(place, summary_of):
    """Of a fresh program of the same contour: but for the chord error of either."""
    before, corrected = place / "plan/armside.mod", place / "run/armside.mod"
    made = summary_of(f"export {place / 'run'} --into {before}")
    written = before.with_name("armside-corrected.mod")
    assert made["changed"] == made["targets"] > 10
    away = KDTree(paths(written)).query(paths(corrected))[0]
    chord = json.loads((place / "plan/summary.json").read_text(encoding="utf-8"))["program"]
    assert np.median(away) < chord["chord_error"] < 1e-4
    assert np.median(KDTree(paths(before)).query(paths(written))[0]) > 3e-4
    summary = json.loads((place / "run/summary.json").read_text(encoding="utf-8"))
    entry, rows = summary["program"], summary["iterations"]
    assert rows[1]["arm_rms_true"] < 0.3 * rows[0]["arm_rms_true"]
    assert entry["largest_offset"] == pytest.approx(made["largest_offset"], rel=0.1)
    assert 1e-4 < entry["largest_offset"] < 3e-3
    assert entry["spacing"] == 0.0015
    (row,) = rows_of(read_program_file(corrected))
    assert entry["blocks_per_second"] == pytest.approx(0.1 / row.spacing.min(), rel=1e-3)


def test_targets_that_move_too_far_are_held_back_with_a_note(
    place, monkeypatch, tmp_path, summary_of
):
    """Bound of a tenth of a millimetre, in place of 5 mm."""
    monkeypatch.setattr(part_program, "LARGEST_OFFSET", 1e-4)
    made = summary_of(f"cut {place / 'hole.svg'} {CUT} {LEARN} --out held")
    assert made["program"]["largest_offset"] == 0.0
    (note,) = (note for note in made["notes"] if note["cause"] == "program")
    assert "at most 0.1 mm are allowed: the program is not corrected" in note["text"]
    before = place / "plan/armside.mod"
    assert (tmp_path / "held/armside.mod").read_bytes() == before.read_bytes()


def test_a_program_is_gone_on_from_and_samples_of_motors_are_not(
    place, samples, summary_of, bad_input
):
    """Run k = 2 of one loop and of two are the same."""
    rows = summary_of(f"cut --from {place / 'run'} --iterations 1 --out more")["iterations"]
    assert [row["k"] for row in rows] == [0, 2]
    stored = json.loads((place / "run/summary.json").read_text(encoding="utf-8"))
    assert rows[0]["arm_rms"] == stored["iterations"][0]["arm_rms"]
    said = "start from a run with --as-program"
    bad_input(f"cut --from {samples} --as-program krl --out other", said)
    said = "in the targets of its program"
    bad_input(f"export {place / 'run'} --to csv --file u.csv", said)


@pytest.fixture(scope="module")
def samples(place):
    """The same part, learned once by samples of the motors."""
    ran(place / "samples", f"cut {place / 'hole.svg'} --speed 100 {LEARN}")
    return place / "samples"


def test_a_correction_beyond_the_gate_enters_no_program(
    samples, place, monkeypatch, summary_of, bad_input, tmp_path
):
    """Gate of a tenth of a milliradian, in place of 5 degrees."""
    monkeypatch.setitem(gate.LIMITS, "size", (1e-4, 1e-4))
    line = f"export {samples} --into {place / 'plan/armside.mod'} --file gated.mod"
    bad_input(line, "size: the correction of axis")
    assert summary_of(f"{line} --beyond size")["notes"][0].startswith("beyond size: ")
    assert (tmp_path / "gated.mod").exists()


ENDED = {
    "diverged": {"status": "diverged"},
    "saturated": {"status": "saturated"},
    "worse": {"status": "worse"},
    "beam": {"notes": [{"cause": "beam", "text": "the beam was lost", "runs": [1]}]},
}


@pytest.mark.parametrize("name", ENDED)
def test_targets_of_a_run_that_ended_badly_are_held_back(
    name, place, tmp_path, summary_of, bad_input
):
    """By the name of its end, which a stored summary is given."""
    run = tmp_path / "run"
    shutil.copytree(place / "run", run)
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8")) | ENDED[name]
    (run / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    line = f"export run --into {place / 'plan/armside.mod'} --file a.mod"
    bad_input(line, f"beyond {name} lets it through")
    assert summary_of(f"{line} --beyond {name}")["notes"][0].startswith(f"beyond {name}: ")


def test_the_persons_program_is_never_written_over(place, bad_input):
    file = place / "plan/armside.mod"
    before = file.read_bytes()
    bad_input(f"export {place / 'run'} --into {file} --file {file}", "is the program itself")
    assert file.read_bytes() == before


def test_read_describes_rows_in_si(place, summary_of):
    made = summary_of(f"program read {place / 'plan/armside.mod'}")
    (row,) = made["rows"]
    assert made["moves"] == {"MoveL": row["targets"] - 1, "MoveC": 0, "MoveJ": 1}
    assert row["zones"][1] == pytest.approx(0.00075)
    assert row["speeds"] == [0.1, 0.1, 0.2]
    assert made["frames"] == {"tool": {"tool0": True}, "base": {"wobj0": True}}


REFUSED = {
    "program read loop.src": "line 2, column 1: loop is not understood",
    "program read part.nc": "programs end with .mod, .src, .script",
    "export {run} --into loop.src": "line 2, column 1: loop",
    "export {run} --into far.src": "no linear moves within 1 mm of the run's path",
    "export {run} --into far.src --to csv": "--to is not for --into",
    "export {run} --into far.src --file a.mod": "--file must end with .src",
    "export {run} --into far.src --law p": "--law is not for a run of a program",
    "export {run} --into far.src --robot large": "--robot is not for a run of a program",
    "program read far.src --measure motor": "are of `program learn`",
    "program learn far.src": "learn needs --recording",
    "program learn far.src --payload -1": "0 to 10000 kg",
    "program learn far.src --recording {run}": "far.src has no row that can be learned",
    "export --into far.src": "--into is of a run",
    "cut hole.svg --spacing 2": "spacing is of --as-program",
    "cut hole.svg --as-program krl --spacing 0.05": "0.1 to 100 mm",
}


@pytest.mark.parametrize("line", REFUSED)
def test_refused_in_one_line(line, place, tmp_path, bad_input):
    moves = [f"LIN {{X {x},Y 0,Z 0,A 0,B 0,C 0}}" for x in (1, 2)]
    head = "$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$VEL.CP=1\n"
    files = {"loop.src": "DEF m( )\nLOOP\nENDLOOP\nEND\n", "part.nc": "G1 X1"}
    files |= {"far.src": f"DEF m( )\n{head}{moves[0]}\n{moves[1]}\nEND\n", "hole.svg": HOLE}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    bad_input(line.format(run=place / "run"), REFUSED[line])


def test_the_entries_of_a_program_are_those_of_chords_of_its_circle(place, tmp_path):
    """Chords of length s at a radius R lie at most s^2 / (8 R) inside; at v at least v / s of them
    come in a second."""
    cut = f"cut {place / 'hole.svg'} --speed 50 --plan-only --as-program urscript --spacing 1"
    entry = ran(tmp_path / "plan", cut)["program"]
    assert "text" not in entry
    assert entry["spacing"] == 1e-3
    assert entry["targets"] >= 2 * 3.1416 * 3
    assert entry["blocks_per_second"] >= 50.0
    assert 0.0 < entry["chord_error"] < 1e-3**2 / (8 * 3e-3)


def test_export_refuses_another_speed_a_corrected_program_and_to_write_over(
    place, tmp_path, bad_input
):
    slow = (place / "plan/armside.mod").read_text(encoding="latin-1")
    speed = "[100,"
    assert slow.count(speed) == 1
    (tmp_path / "slow.mod").write_text(slow.replace(speed, "[40,"), encoding="latin-1")
    said = "moves at 40 mm/s, the run was programmed with 100: a correction belongs to one speed"
    bad_input(f"export {place / 'run'} --into slow.mod", said)
    (tmp_path / "own.mod").write_text(slow, encoding="latin-1")
    (tmp_path / "own-corrected.mod").write_text("mine", encoding="latin-1")
    bad_input(f"export {place / 'run'} --into own.mod", "own-corrected.mod exists: give a --file")


def test_run_records_a_program_on_the_virtual_robot_as_learn_takes_it(
    place, tmp_path, summary_of, bad_input
):
    """The recorded error is that of the part's own run; an individual is of run alone."""
    file = place / "plan/armside.mod"
    found = summary_of(f"program run {file} --individual 7 --out run0")
    assert found["seconds"] > 1.0
    names = {each.name for each in (tmp_path / "run0").iterdir()}
    assert names == {"encoders.csv", "tracker.csv", "imu.csv", "summary.json"}
    learned = summary_of(f"program learn {file} --recording run0 --out learned0")
    assert 1e-4 < learned["rms"] < 1e-3
    assert learned["changed"] > 5
    assert not any(note["cause"] == "imu" for note in learned["notes"])
    line = f"program learn {file} --recording run0 --individual 7"
    bad_input(line, "individual is of `program run`")
    bad_input(f"program run {file} --recording run0", "are of `program learn`")
