"""What the summary of a cut says of its program."""

import json

import pytest

from armside.scripts.cli import main

HOLE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
<circle cx="20" cy="20" r="3" fill="none" stroke="black"/></svg>"""


def test_the_entries_of_a_program_are_those_of_chords_of_its_circle(tmp_path):
    """Chords of length s at a radius R lie at most s^2 / (8 R) inside; at v at least v / s of them
    come in a second."""
    pytest.importorskip("svgelements")
    (tmp_path / "hole.svg").write_text(HOLE, encoding="utf-8")
    out = tmp_path / "plan"
    cut = ["cut", str(tmp_path / "hole.svg"), "--speed", "50", "--quiet", "--plan-only"]
    assert main([*cut, "--as-program", "urscript", "--spacing", "1", "--out", str(out)]) == 0
    entry = json.loads((out / "summary.json").read_text(encoding="utf-8"))["program"]
    assert "text" not in entry
    assert entry["spacing"] == 1e-3
    assert entry["targets"] >= 2 * 3.1416 * 3
    assert entry["blocks_per_second"] >= 50.0
    assert 0.0 < entry["chord_error"] < 1e-3**2 / (8 * 3e-3)
