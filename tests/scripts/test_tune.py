"""`armside tune`: finds, prunes, resumes, shares, and says what is wrong."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import optuna
import pytest

from armside.scripts.commands import tune
from armside.scripts.figures import tuning as tune_figures
from armside.scripts.shell import console
from armside.scripts.shell.interrupts import noticing
from armside.scripts.shell.options import Common
from armside.scripts.studies import report as tune_report
from armside.scripts.studies import storage as study_storage
from armside.scripts.studies import study as studies
from armside.scripts.studies.options import TuneCfg
from armside.scripts.studies.search import evaluate, run_trial, search
from armside.scripts.studies.study import Outcome, open_study
from armside.sim.laser.design import THESIS, Design
from armside.sim.tuning import objective as tuning_objective
from armside.sim.tuning.action import Motors
from armside.sim.tuning.objective import WORST, Objective, Ratio, prepare
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.sensor import RewardSensor

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1"


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """A busy machine may take seconds to open a storage, which is then announced."""
    monkeypatch.setattr(study_storage, "SLOW", 60.0)


def _objective(**options):
    cfg = TuneCfg(pose="p1", speed=60.0, **options)
    return Objective(cfg.rules, prepare(cfg.rules, range(cfg.episodes), cfg.fixed))


def test_a_study_ends_with_its_best_design_plots_and_importances(armside, tmp_path):
    status, out, err = armside(f"tune {QUICK} --trials 10 --pruner none --sampler random --out a")
    assert (status, err) == (0, "")
    summary = json.loads((tmp_path / "a" / "summary.json").read_text())
    done = summary["trials"]["complete"]
    assert done == 10
    ratios = [best["ratio"] for best in summary["bests"]]
    assert ratios == sorted(ratios, reverse=True)
    assert summary["best"] == summary["bests"][-1]
    assert summary["bests"][0]["delta"] == THESIS.delta[0]  # is tried first
    shares = summary["importance"]
    assert set(shares) == {"gamma", "delta", "cutoff"}
    assert sum(one["share"] for one in shares.values()) == pytest.approx(1.0)
    assert summary["best"]["ratio_true"] == pytest.approx(summary["best"]["ratio"], rel=0.1)
    assert "best so far, trial" in out
    assert "(PED-ANOVA)" in out
    assert "by the tracker" in out
    assert "[samples]" in out
    for figure in ("history.png", "importance.png"):
        assert (tmp_path / "a" / figure).read_bytes().startswith(b"\x89PNG")


def test_a_study_resumes_as_if_it_had_not_been_interrupted(armside, tmp_path):
    def best(out):
        return json.loads((tmp_path / out / "summary.json").read_text())["bests"]

    line = f"tune {QUICK} --quiet --storage sqlite:///{tmp_path}"
    for trials, out in ((3, "a"), (6, "b")):
        assert armside(f"{line}/halves.db --trials {trials} --out {out}").status == 0
    assert armside(f"{line}/whole.db --trials 6 --out c").status == 0
    assert best("b") == best("c")
    assert armside(f"{line}/whole.db --trials 6 --out d").status == 0  # nothing left to do
    assert best("d") == best("c")


def test_a_study_of_something_else_is_refused(armside):
    line = f"tune {QUICK} --quiet --trials 1 --study a"
    assert armside(line).status == 0
    status, _, err = armside(f"{line} --motors each")
    assert status == 2
    assert "tunes something else: motors differ" in err


def test_searches_of_different_things_do_not_meet_unless_they_are_named(armside, tmp_path):
    for out, more in (("a", ""), ("b", "--motors each"), ("c", "")):
        assert armside(f"tune {QUICK} --quiet --trials 1 {more} --out {out}").status == 0
    studies = [
        json.loads((tmp_path / out / "summary.json").read_text())["config"]["study"]
        for out in "abc"
    ]
    assert studies[0] == studies[2] != studies[1]
    assert studies[0].startswith("large-shared-tracker-")
    assert TuneCfg(trials=3).named(0).study == TuneCfg(sampler="random").named(0).study
    assert TuneCfg().named(0).study != TuneCfg().named(1).study


def test_motors_are_not_taken_for_the_tool(armside, tmp_path):
    """What they see falls by far more than what the tool does; both are told."""
    status, out, _ = armside(f"tune {QUICK} --reward motor --trials 2 --out a")
    assert status == 0
    best = json.loads((tmp_path / "a" / "summary.json").read_text())["best"]
    assert best["ratio"] < 0.8 * best["ratio_true"]
    assert "by the motors" in out
    assert f"true {best['ratio_true']:.3f}" in out


def test_hopeless_designs_are_pruned_between_iterations():
    study = optuna.create_study(pruner=optuna.pruners.ThresholdPruner(upper=1e-3))
    with (
        _objective(payload=40.0, episodes=1, iterations=3) as objective,
        pytest.raises(optuna.TrialPruned),
    ):
        evaluate(objective, study.ask())
    assert list(study.trials[0].intermediate_values) == [1]


def test_every_design_meets_the_same_noise_and_divergence_is_the_worst():
    with _objective(payload=40.0, episodes=2, iterations=2) as objective:
        first, again = (list(objective.ratios(THESIS)) for _ in range(2))
    assert first == again
    assert len(first) == 2
    assert first[-1].measured < 1.0
    assert first[-1].true < 1.0
    bold = Design(gamma=(1.5,), delta=(0,), cutoff=(30.0,))
    with _objective(episodes=1, iterations=10) as objective:
        assert list(objective.ratios(bold))[-1] == Ratio(WORST, WORST)


def test_where_all_designs_diverge_there_is_no_best_one(armside, tmp_path, monkeypatch):
    """The storage keeps what was tried; no folder of results is made of it."""
    monkeypatch.setattr(tuning_objective, "mean_ratio", lambda pairs: WORST)
    status, _, err = armside(f"tune {QUICK} --trials 6 --out a")
    assert status == 1
    assert err.splitlines()[-1].endswith("all 6 designs that were tried to the end diverged")
    assert "Warning" not in err
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize("sampler", ["random", "cmaes"])
def test_other_samplers_propose_designs(armside, sampler):
    assert armside(f"tune {QUICK} --quiet --trials 3 --sampler {sampler}").status == 0


def test_a_search_that_is_interrupted_says_what_is_kept(armside, monkeypatch):
    def interrupted(study, *_, **__):
        study.optimize(lambda trial: 0.5, n_trials=1)
        raise KeyboardInterrupt

    monkeypatch.setattr(tune, "search", interrupted)
    status, _, err = armside(f"tune {QUICK} --study a --storage sqlite:///b.db")
    assert status == 130
    assert "kept in study 'a' of 'sqlite:///b.db': 1" in err


def test_ctrl_c_in_the_first_runs_says_what_is_kept_from_before(armside, monkeypatch):
    def interrupted(rules, episodes, stop):
        raise KeyboardInterrupt

    line = f"tune {QUICK} --quiet --trials 1 --study a --storage sqlite:///b.db"
    assert armside(line).status == 0
    monkeypatch.setattr(tune, "Objective", interrupted)
    status, _, err = armside(line)
    assert status == 130
    assert "kept in study 'a' of 'sqlite:///b.db': 1" in err


SLOW_RUNS = """
import sys, time
from armside.scripts import cli
from armside.scripts.studies import storage
from armside.sim.tuning.rules import Rules

storage.SLOW = 60.0

def slow(*args, advance=Rules.advance):
    time.sleep(0.3)
    return advance(*args)

Rules.advance = slow
sys.exit(cli.main())
"""


def test_ctrl_c_twice_is_one_interruption(tmp_path):
    """The second comes while the runs in flight are waited for."""
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW_RUNS, "tune", *QUICK.split()],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()  # the first trial is done, the second waits for its run
    time.sleep(0.1)
    for _ in range(2):
        process.send_signal(signal.SIGINT)
        time.sleep(0.1)
    _, err = process.communicate(timeout=60)
    # A shell calls both 130: Python lets go of signals before it ends.
    assert process.returncode in (130, -signal.SIGINT)
    assert err.startswith("armside: interrupted; finished trials kept in study")
    assert err.count("\n") == 1


def test_what_goes_wrong_after_ctrl_c_is_an_interruption():
    def stopped_twice(then):
        with noticing(lambda: "kept") as stop:
            for _ in range(2):
                signal.raise_signal(signal.SIGINT)
            assert stop.asked
            then()

    def broken():
        raise UnboundLocalError

    before = signal.getsignal(signal.SIGINT)
    for then in (broken, lambda: None):  # noticed at the end, if not before
        with pytest.raises(KeyboardInterrupt, match="kept"):
            stopped_twice(then)
        assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(UnboundLocalError), noticing(lambda: "kept"):
        broken()


def test_the_threads_of_a_search_end_whatever_happens(monkeypatch):
    def broken(*args):
        raise RuntimeError("a run failed")

    known = set(threading.enumerate())
    monkeypatch.setattr(Rules, "advance", broken)
    with pytest.raises(RuntimeError), _objective(payload=40.0, episodes=2) as objective:
        next(objective.ratios(THESIS))
    monkeypatch.setattr(Rules, "first", broken)
    with pytest.raises(RuntimeError):
        _objective(payload=40.0, episodes=2)
    assert set(threading.enumerate()) == known


def test_the_history_marks_what_lies_beyond_its_axis(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(tune_figures, "save", lambda figure, file: drawn.append(figure))
    tried = [Outcome(0, 0.5, 0.6, True), Outcome(1, 1e3, 1e3, True), Outcome(2, 9.0, 8.0, True)]
    tune_figures.history(tmp_path / "a.png", tried, sensor="by the motors")
    (axes,) = drawn[0].axes
    lines = {line.get_label(): line for line in axes.lines}
    assert axes.get_ylim()[1] > 9.0  # whatever is finite is inside
    assert list(lines["diverged, beyond the axis"].get_xdata()) == [1]
    assert list(lines["best so far, by the motors"].get_ydata()) == [0.5] * 3
    assert list(lines["same design, ground truth"].get_ydata()) == [0.6] * 3


@pytest.mark.parametrize("width", [60, 80])
@pytest.mark.parametrize("motors", list(Motors))
def test_every_number_can_be_read_in_a_narrow_terminal(monkeypatch, capsys, motors, width):
    monkeypatch.setenv("COLUMNS", str(width))
    rng = np.random.default_rng(0)
    values = studies.parameters(THESIS, motors)
    values = {name: float(rng.uniform(0.1, 30.0)) for name in values}
    best = {"trial": 1234, "ratio": 0.54321, "ratio_true": 0.65432} | values
    outcome = {
        "config": {"reward": "estimate", "study": "a", "storage": "b"},
        "trials": {"complete": 55},
        "bests": [best],
        "best": best,
        "importance": {key: {"share": 0.12345, "by_chance": 0.23456} for key in values},
    }
    tune_report.tables(console.Report(Common()), outcome, Path("c"))
    out = capsys.readouterr().out
    words = out.replace("│", " ").split()
    assert {console.cell(value) for value in (*best.values(), 0.12345, 0.23456)} <= set(words)
    assert "…" not in out


@pytest.mark.parametrize("motors", list(Motors))
def test_a_new_best_design_is_told_in_short_lines(capsys, motors):
    values = dict.fromkeys(studies.parameters(THESIS, motors), 0.12345)
    study = optuna.create_study()
    trial = optuna.trial.create_trial(
        params=values,
        distributions={n: optuna.distributions.FloatDistribution(0.0, 1.0) for n in values},
        value=0.54321,
        user_attrs={studies.TRUE: 0.65432},
    )
    study.add_trial(trial)
    tune_report.new_best(console.Report(Common()), study.trials[0], RewardSensor.ESTIMATE)
    first, second = capsys.readouterr().out.splitlines()
    assert first == "best so far, trial 0: ratio 0.543 by the estimate"
    assert second.startswith("true 0.654")
    assert ("gamma" in second) is (motors is Motors.SHARED)
    assert len(first) <= 60
    assert len(second) <= 66  # of which the last four are a unit


@pytest.mark.parametrize("ends", [(0.5, 0.4), (0.5, 1e3), (0.5, 0.4, 1e3, None)])
def test_the_legend_stands_on_the_axes_and_inside_the_picture(tmp_path, monkeypatch, ends):
    drawn = []
    monkeypatch.setattr(tune_figures, "save", lambda figure, file: drawn.append(figure))
    tried = [Outcome(i, r or 0.9, r or 0.9, r is not None) for i, r in enumerate(ends)]
    tune_figures.history(tmp_path / "a.png", tried, sensor="by the estimate")
    (axes,) = drawn[0].axes
    drawn[0].canvas.draw()
    box, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
    gap = 0.2 * drawn[0].dpi  # less than a line of text
    assert 0.0 <= legend.y0 - box.y1 < gap
    assert 0.0 <= drawn[0].bbox.y1 - legend.y1 < gap
    assert drawn[0].bbox.x0 <= legend.x0 < legend.x1 <= drawn[0].bbox.x1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--storage postgresql+psycopg://nobody@127.0.0.1:1/none", "does not answer"),
        ("--storage nonsense", "'nonsense' is no SQLAlchemy URL"),
        ("--storage strange://a:secret@b/c", "is no SQLAlchemy URL"),
        ("--storage sqlite:////proc/none/x.db", "does not answer"),
        ("--storage postgresql+pg8000://a:secret@127.0.0.1/b", "needs the database driver pg8000"),
        ("--pose p9", "Unknown pose 'p9'"),
        ("--speed 0", "speed must be from 1 to 100 mm/s, got 0"),
        ("--speed 500", "speed must be from 1 to 100 mm/s, got 500"),
        ("--payload=-1", "payload must be >= 0 kg"),
        ("--payload 5000", "cannot carry its load"),
        ("--study=", "study must have a name"),
        ("--trials 0", "trials must be >= 1"),
        ("--sampler genius", "sampler"),
        ("--seed 900000000", "sealed test seeds"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(armside, tmp_path, options, message):
    status, out, err = armside(f"tune --episodes 1 --iterations 1 {options}")
    assert (status, out) == (2, "")
    assert message in err
    assert "secret" not in err
    assert err.count("\n") == 1
    assert not [path for path in tmp_path.rglob("*") if path.name != "runs"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--storage nonsense", "is no SQLAlchemy URL"),
        ("--out taken/a", "no folder can be made in"),
        ("--study a", "motors differ"),
    ],
)
def test_bad_input_is_found_before_the_first_runs(armside, tmp_path, monkeypatch, options, message):
    taken = tmp_path / "taken"
    taken.mkdir()
    assert armside(f"tune {QUICK} --trials 1 --study a").status == 0
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != taken)
    monkeypatch.setattr(tune, "Objective", None)
    status, _, err = armside(f"tune {QUICK} --trials 1 --motors each {options}")
    assert status == 2
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.filterwarnings("ignore:Heartbeat of storage")
def test_what_other_processes_add_is_counted_and_told_once(tmp_path, monkeypatch):
    def theirs(trial):
        if trial.number in better:  # another process ends two while ours runs
            for value in (better[trial.number], 0.9):
                other.add_trial(
                    optuna.trial.create_trial(value=value, user_attrs={studies.TRUE: value})
                )
        trial.set_user_attr(studies.TRUE, 0.5)
        return 0.5

    better = {0: 0.4, 3: 0.2}
    url = f"sqlite:///{tmp_path}/a.db"
    ours, other = (
        open_study(url, "a", {}, sampler="random", pruner="none", seed=0) for _ in range(2)
    )
    told, steps = [], []
    monkeypatch.setattr(studies, "ask_first", lambda *_: None)
    search(
        ours,
        theirs,
        5,
        {},
        check=lambda: None,
        step=lambda: steps.append(1),
        new_best=lambda trial: told.append(trial.value),
    )
    assert told == [0.5, 0.4, 0.2]
    assert len(steps) == 5


@pytest.mark.filterwarnings("ignore:Heartbeat of storage")
def test_a_trial_that_others_took_for_dead_is_left_to_them(tmp_path):
    url = f"sqlite:///{tmp_path}/a.db"
    ours, other = (
        open_study(url, "a", {}, sampler="random", pruner="none", seed=0) for _ in range(2)
    )
    with _objective(payload=40.0, episodes=1, iterations=1) as objective:

        def slept(trial):
            theirs = other._storage
            theirs.set_trial_state_values(other.trials[0]._trial_id, optuna.trial.TrialState.FAIL)
            return evaluate(objective, trial)

        run_trial(ours, slept)
        run_trial(ours, partial(evaluate, objective))
    assert [t.state.name for t in ours.trials] == ["FAIL", "COMPLETE"]


def test_a_search_is_not_part_of_what_makes_studies_comparable():
    one, other = TuneCfg(trials=3, sampler="random"), TuneCfg(trials=9, pruner="none")
    assert one.identity(0) == other.identity(0)
    assert one.identity(0) != one.identity(1)


def test_without_optuna_the_extra_is_named(armside, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "optuna", None)
    status, out, err = armside("tune")
    assert (status, out) == (2, "")
    assert err == "armside: armside tune needs Optuna: pip install 'armside[tuning]'\n"
    assert not list(tmp_path.iterdir())


def test_a_limit_that_changed_what_was_asked_is_noted(armside):
    fast = QUICK.replace("--speed 60", "--speed 100")
    status, out, _ = armside(f"tune {fast} --trials 1 --json")
    assert status == 0
    (note,) = json.loads(out)["notes"]
    assert note["cause"] == "speed"
    assert "from 100 to 80.62 mm/s" in note["text"]
    assert note["text"].endswith("(in 1 of 1 episodes)")


def test_limits_that_the_best_design_touches_are_noted():
    study = optuna.create_study()
    for value, text in ((0.5, "drives saturate"), (0.4, "speed limit is reached"), (0.9, "worse")):
        stored = [{"cause": "saturation", "text": text, "runs": []}]
        study.add_trial(optuna.trial.create_trial(value=value, user_attrs={studies.NOTES: stored}))
    (note,) = studies.notes_of_best(study)
    assert note.line == "with the best design speed limit is reached"
    assert studies.notes_of_best(optuna.create_study()) == []
