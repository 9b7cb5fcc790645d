"""The commands of chapter 8 write what they promise and refuse what they cannot do."""

import json

import pytest

from armside.scripts.cli import main
from armside.scripts.commands.two_mass import FIGURE_NAMES
from armside.scripts.figures import two_mass as two_mass_figures

QUICK = ("8.3", "8.6", "8.8", "8.12", "why-q")


def test_the_names_of_figures_are_those_that_can_be_drawn():
    assert tuple(two_mass_figures.FIGURES) == FIGURE_NAMES


def test_two_mass_writes_a_figure_and_a_table_for_each_name(tmp_path, capsys):
    out = tmp_path / "run"
    assert main(["two-mass", "--figure", *QUICK, "--out", str(out)]) == 0
    assert sorted(p.name for p in out.glob("*.png")) == sorted(f"figure-{n}.png" for n in QUICK)
    assert all(p.stat().st_size > 10_000 for p in out.glob("*.png"))
    tables = json.loads((out / "summary.json").read_text())["figures"]
    assert list(tables) == list(QUICK)
    row = tables["8.8"]["rows"][-1]
    assert row[0] == "17 Hz"
    assert row[1] == pytest.approx(5.32128, rel=1e-4)
    printed = capsys.readouterr().out
    assert "Fig 8.12: arm side, stiffness doubled in F_r" in printed


def test_the_same_figure_has_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        assert main(["two-mass", "--figure", "8.4", "--out", str(tmp_path / name), "--quiet"]) == 0
    one, two = ((tmp_path / name / "figure-8.4.png").read_bytes() for name in ("a", "b"))
    assert one == two


def test_design_prints_its_sentence_and_writes_its_numbers(tmp_path, capsys):
    file = tmp_path / "servo.json"
    file.write_text(json.dumps({"sample_time": 0.004, "b": [0, 0, 0, 0.6], "a": [1, -0.4]}))
    out = tmp_path / "run"
    assert main(["design", "--model", str(file), "--bandwidth", "12", "--out", str(out)]) == 0
    design = json.loads((out / "summary.json").read_text())["design"]
    assert design["sentence"] in capsys.readouterr().out
    assert design["contraction"] < 0.5
    assert (out / "design.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["two-mass", "--figure", "8.77"], "Unknown figure '8.77'. Did you mean 8.7?"),
        (["design", "--model", "nothing"], "no model 'nothing'"),
        (["design", "--bandwidth", "50"], "below the Nyquist frequency 50 Hz"),
        (["design", "--bandwidth", "-1"], "bandwidth must be > 0 Hz"),
        (["design", "--model", "two-mass-arm", "--bandwidth", "45"], "infeasible design"),
        (["design", "--share", "1.5"], "share must be in (0, 1)"),
    ],
)
def test_bad_input_ends_with_one_line_and_writes_nothing(words, message, tmp_path, capsys):
    out = tmp_path / "run"
    assert main([*words, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not out.exists()
