"""The commands of chapter 8 write what they promise and refuse what they cannot do."""

import json
import math

import pytest

from armside.ilc import two_mass_study
from armside.scripts.cli import main
from armside.scripts.commands.two_mass import FIGURE_NAMES
from armside.scripts.figures import two_mass as two_mass_figures
from armside.scripts.workbench.two_mass import study_of

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


OF_A_LAW = ("8.3", "8.9", "nyquist")


def test_figures_take_the_users_joint_and_law(tmp_path, capsys):
    """A stiffer joint has its notch higher; the law stands beside the others."""
    design = ["--joint", "k=20", "Ja=0.08", "--gamma", "0.5", "--delta", "2", "--cutoff", "5"]
    own = ["--law", "heuristic:gamma=0.4,delta=2,cutoff=5"]
    words = ["--figure", *OF_A_LAW, *design, *own, "--out", str(tmp_path / "a")]
    assert main(["two-mass", *words]) == 0
    assert "Not the numbers of the thesis: heuristic:gamma=0.4" in capsys.readouterr().out
    tables = json.loads((tmp_path / "a" / "summary.json").read_text())["figures"]
    undamped = tables["8.3"]["rows"][2][1]
    assert undamped == pytest.approx((20.0 / 0.08) ** 0.5 / (2.0 * math.pi), rel=1e-6)
    first, last = tables["8.9"]["rows"][0][1], tables["8.9"]["rows"][-1][1]
    assert last < 0.5 * first


def test_learn_has_the_joint_of_the_study_and_can_go_on(tmp_path):
    """The figures are fixed experiments; to go on, the joint is learned as any other plant."""
    words = ["learn", "--plant", "two-mass", "--laws", "norm-optimal", "--iterations", "3"]
    assert main([*words, "--quiet", "--out", str(tmp_path / "a")]) == 0
    (row,) = json.loads((tmp_path / "a/summary.json").read_text())["laws"]
    study = study_of((), 0.9, 5, 17.0, "norm-optimal")
    of_figures = two_mass_study.run(study.plant, study.one_law, 3)
    assert row["error_two"] == pytest.approx(list(of_figures.motor), rel=1e-12)  # rounding


def test_learning_that_overflows_is_a_failure_in_one_line(tmp_path, capsys):
    words = ["--figure", "8.9", "--gamma", "90", "--cutoff", "45", "--out", str(tmp_path / "a")]
    assert main(["two-mass", *words]) == 1
    error = capsys.readouterr().err
    assert "learning diverges: its error is" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "a").exists()


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
        (["two-mass", "--joint", "K=5"], "Unknown number of the joint 'K'"),
        (["two-mass", "--joint", "k=5e9"], "k must be 0.005 to 5000"),
        (["two-mass", "--joint", "k"], "joint takes KEY=VALUE"),
        (["two-mass", "--law", "herustic"], "Unknown law 'herustic'"),
        (["two-mass", "--gamma", "0"], "gamma must be > 0"),
        (["two-mass", "--cutoff", "50"], "cutoff must be 0.1 to 49 Hz"),
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
