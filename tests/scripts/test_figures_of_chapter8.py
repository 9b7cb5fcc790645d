"""Chapter 8 by `reproduce`, of any joint and design, and the command `design`."""

import json
import math

import pytest

from armside.ilc import two_mass_study
from armside.scripts.cli import main
from armside.scripts.workbench.joint import study_of


def sections(folder):
    """Tables of a report: id: rows."""
    files = sorted((folder / "sections").glob("*.json"))
    return {file.stem: json.loads(file.read_text())["tables"][0]["rows"] for file in files}


def test_figures_beyond_the_thesis_are_drawn_by_name_and_each_with_the_same_bytes(tmp_path, capsys):
    for name, ids in (("a", ["8.4", "why-q"]), ("b", ["8.4"])):
        assert main(["reproduce", *ids, "--out", str(tmp_path / name)]) == 0
    assert "Why Q: where the phase of L Tu is beyond 90 degrees" in capsys.readouterr().out
    one, other = ((tmp_path / name / "figures/8.4.png").read_bytes() for name in ("a", "b"))
    assert one == other
    assert min(len(one), (tmp_path / "a/figures/why-q.png").stat().st_size) > 10_000


OF_A_LAW = ("8.3", "8.9", "nyquist")


def test_figures_take_the_users_joint_and_law(tmp_path, capsys):
    """A stiffer joint has its notch higher; nothing is compared with the thesis."""
    design = ["--joint", "k=20", "Ja=0.08", "--gamma", "0.5", "--delta", "2", "--cutoff", "5"]
    own = ["--law", "heuristic:gamma=0.4,delta=2,cutoff=5"]
    out = tmp_path / "a"
    assert main(["reproduce", *OF_A_LAW, *design, *own, "--out", str(out)]) == 0
    assert "comparisons" not in capsys.readouterr().out
    text = (out / "report.md").read_text()
    assert "Not the numbers of the thesis: heuristic:gamma=0.4" in text
    assert "--joint k=20 Ja=0.08 --gamma 0.5 --delta 2 --cutoff 5.0 --law heuristic:" in text
    found = sections(out)
    assert found["8.3"][2][1] == pytest.approx((20.0 / 0.08) ** 0.5 / (2.0 * math.pi), rel=1e-6)
    assert found["8.9"][-1][1] < 0.5 * found["8.9"][0][1]


def test_learn_has_the_joint_of_the_study_and_can_go_on(tmp_path):
    """The figures are fixed experiments; to go on, the joint is learned as any other plant."""
    words = ["learn", "--plant", "two-mass", "--laws", "norm-optimal", "--iterations", "3"]
    assert main([*words, "--quiet", "--out", str(tmp_path / "a")]) == 0
    (row,) = json.loads((tmp_path / "a/summary.json").read_text())["laws"]
    study = study_of((), 0.9, 5, 17.0, "norm-optimal")
    of_figures = two_mass_study.run(study.plant, study.one_law, 3)
    assert row["error_two"] == pytest.approx(list(of_figures.motor), rel=1e-12)  # rounding


def test_learning_that_overflows_is_a_failure_in_one_line(tmp_path, capsys):
    words = ["--gamma", "90", "--cutoff", "45", "--out", str(tmp_path / "a")]
    assert main(["reproduce", "8.9", *words]) == 1
    error = capsys.readouterr().err
    assert "learning diverges: its error is" in error
    assert error.count("\n") == 1
    assert not (tmp_path / "a" / "report.html").exists()


def test_design_prints_its_sentence_and_writes_its_numbers(tmp_path, capsys):
    file = tmp_path / "servo.json"
    file.write_text(json.dumps({"sample_time": 0.004, "b": [0, 0, 0, 0.6], "a": [1, -0.4]}))
    out = tmp_path / "run"
    assert main(["design", "--model", str(file), "--cutoff", "12", "--out", str(out)]) == 0
    design = json.loads((out / "summary.json").read_text())["design"]
    assert design["sentence"] in capsys.readouterr().out
    assert design["contraction"] < 0.5
    assert (out / "design.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("reproduce 8 --joint K=5", "Unknown number of the joint 'K'"),
        ("reproduce 8 --joint k=5e9", "k must be 0.005 to 5000"),
        ("reproduce 8 --joint k", "joint takes KEY=VALUE"),
        ("reproduce 8 --law herustic", "Unknown law 'herustic'"),
        ("reproduce 8 --gamma 0", "gamma must be in (0, 100]"),
        ("reproduce 8 --cutoff 50", "cutoff must be 0.1 to 49 Hz"),
        ("reproduce 8.77", "Unknown figure, chapter or row '8.77'. Did you mean 8.7?"),
        ("reproduce 9.5 --gamma 0.5", "are of the figures of chapter 8, not of 9.5"),
        ("design --model nothing", "no model 'nothing'"),
        ("design --cutoff 50", "below the Nyquist frequency 50 Hz"),
        ("design --cutoff -1", "cutoff must be > 0 Hz"),
        ("design --cutoff 0.0499", "cutoff must be >= 0.05 Hz, below which no criterion"),
        ("design --model two-mass-arm --cutoff 45", "infeasible design"),
        ("design --share 1.5", "share must be in (0, 1)"),
    ],
)
def test_bad_input_ends_with_one_line_and_writes_nothing(bad_input, line, message):
    bad_input(f"{line} --out run", message)
