"""What `armside tune` shows: figures, tables, lines of progress, and notes."""

import json
from pathlib import Path

import numpy as np
import optuna
import pytest

from armside.scripts.figures import tuning as tune_figures
from armside.scripts.shell import console
from armside.scripts.shell.options import Common
from armside.scripts.studies import study as studies
from armside.scripts.studies import tune_report
from armside.scripts.studies.search import search
from armside.scripts.studies.study import Outcome
from armside.scripts.studies.tune_report import importance
from armside.sim.laser.design import THESIS
from armside.sim.tuning.action import Motors
from armside.sim.tuning.situation import RewardSensor

from .quick_tuning import QUICK, opened

pytestmark = pytest.mark.usefixtures("patient")


def test_the_history_marks_what_lies_beyond_its_axis(tmp_path, drawn):
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
    best = {"trial": 1234, "ratio": 0.54321, "ratio_true": 0.65432, "criterion": 0.87654} | values
    outcome = {
        "config": {"reward": "estimate", "measure": "motor", "study": "a", "storage": "b"},
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
def test_the_legend_stands_on_the_axes_and_inside_the_picture(tmp_path, drawn, ends):
    tried = [Outcome(i, r or 0.9, r or 0.9, r is not None) for i, r in enumerate(ends)]
    tune_figures.history(tmp_path / "a.png", tried, sensor="by the estimate")
    (axes,) = drawn[0].axes
    drawn[0].canvas.draw()
    box, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
    gap = 0.2 * drawn[0].dpi  # less than a line of text
    assert 0.0 <= legend.y0 - box.y1 < gap
    assert 0.0 <= drawn[0].bbox.y1 - legend.y1 < gap
    assert drawn[0].bbox.x0 <= legend.x0 < legend.x1 <= drawn[0].bbox.x1


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
    ours, other = (opened(tmp_path, sampler="random") for _ in range(2))
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


def _searched(rng, n_trials, n_parameters, objective):
    """A random search in which `objective` says what a point is worth."""
    unit = optuna.distributions.FloatDistribution(0.0, 1.0)
    study = optuna.create_study()
    for x in rng.uniform(size=(n_trials, n_parameters)):
        params = {f"x{i}": value for i, value in enumerate(x.tolist())}
        kinds = dict.fromkeys(params, unit)
        study.add_trial(
            optuna.trial.create_trial(params=params, distributions=kinds, value=objective(x))
        )
    return study


@pytest.mark.parametrize(("n_parameters", "n_trials"), [(3, 60), (18, 100)])
def test_importances_name_what_matters(n_parameters, n_trials):
    rng = np.random.default_rng(0)
    found = importance(_searched(rng, n_trials, n_parameters, lambda x: (x[1] - 0.3) ** 2))
    assert next(iter(found)) == "x1"
    assert [name for name, one in found.items() if one.share > one.by_chance] == ["x1"]
    assert sum(one.share for one in found.values()) == pytest.approx(1.0)


def test_noise_is_not_told_from_chance_and_few_trials_are_not_asked():
    rng = np.random.default_rng(1)
    for _ in range(3):
        found = importance(_searched(rng, 20, 3, lambda x: rng.normal()))
        assert all(one.share <= one.by_chance for one in found.values())
    assert importance(_searched(rng, 9, 3, lambda x: (x[1] - 0.3) ** 2)) == {}
