"""`armside tune`: finds, prunes, resumes, shares, and says what is wrong."""

import json
import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import optuna
import pytest
from optuna.storages._heartbeat import get_heartbeat_thread

from scripts import study as studies
from scripts import study_storage, tune, tune_figures, tune_objective
from scripts.errors import InputError
from scripts.study import WORST, Tried, open_study, suggest
from scripts.tune import TuneCfg, _fixed, _identity, rules, study_name
from scripts.tune_objective import Objective, Ratio, prepare
from sim.tuning.design import THESIS, Design, Motors

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1"


def _objective(**options):
    cfg = TuneCfg(pose="p1", speed=60.0, **options)
    return Objective(rules(cfg), prepare(rules(cfg), range(cfg.episodes), _fixed(cfg)))


def test_a_study_ends_with_its_best_design_plots_and_importances(armside, tmp_path, monkeypatch):
    shares = {"delta": 0.6, "gamma": 0.3, "cutoff": 0.1}
    monkeypatch.setattr(tune, "importance", lambda study: shares)
    status, out, err = armside(f"tune {QUICK} --trials 10 --pruner none --sampler random --out a")
    assert (status, err) == (0, "")
    summary = json.loads((tmp_path / "a" / "summary.json").read_text())
    done = summary["trials"]["complete"]
    assert done == 10
    ratios = [best["ratio"] for best in summary["bests"]]
    assert ratios == sorted(ratios, reverse=True)
    assert summary["best"] == summary["bests"][-1]
    assert summary["bests"][0]["delta"] == THESIS.delta[0]  # is tried first
    assert summary["importance"] == shares
    assert summary["best"]["ratio_true"] == pytest.approx(summary["best"]["ratio"], rel=0.1)
    assert "best so far, trial" in out
    assert "Importance of each parameter" in out
    assert "as the tracker sees it" in out
    assert "cutoff [Hz]" in out
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
    assert study_name(TuneCfg(trials=3), 0) == study_name(TuneCfg(sampler="random"), 0)
    assert study_name(TuneCfg(), 0) != study_name(TuneCfg(), 1)


def test_motors_are_not_taken_for_the_tool(armside, tmp_path):
    """What they see falls by far more than what the tool does; both are told."""
    status, out, _ = armside(f"tune {QUICK} --reward motor --trials 2 --out a")
    assert status == 0
    best = json.loads((tmp_path / "a" / "summary.json").read_text())["best"]
    assert best["ratio"] < 0.8 * best["ratio_true"]
    assert "as the motors see it" in out
    assert f"{best['ratio_true']:.3f} in truth" in out


def test_hopeless_designs_are_pruned_between_iterations():
    study = optuna.create_study(pruner=optuna.pruners.ThresholdPruner(upper=1e-3))
    with (
        _objective(payload=40.0, episodes=1, iterations=3) as objective,
        pytest.raises(optuna.TrialPruned),
    ):
        objective(study.ask())
    assert list(study.trials[0].intermediate_values) == [1]


@pytest.mark.filterwarnings("ignore:Heartbeat of storage")
def test_a_design_that_learns_slowly_is_not_given_up_early(tmp_path):
    study = open_study(
        f"sqlite:///{tmp_path}/a.db", "a", {}, sampler="random", pruner="percentile", seed=0
    )
    for _ in range(10):
        trial = study.ask()
        for k in range(1, 6):
            trial.report(0.5, k)
        study.tell(trial, 0.5)
    slow = study.ask()
    given_up = []
    for k in range(1, 6):
        slow.report(0.6, k)
        given_up.append(slow.should_prune())
    assert given_up == [False, False, True, True, True]


def test_a_design_that_was_given_up_is_never_the_best():
    ends = {0.5: None, 0.1: optuna.trial.TrialState.PRUNED, 0.4: None}
    study = optuna.create_study()
    for ratio, end in ends.items():
        trial = study.ask()
        trial.report(ratio, 3)
        study.tell(trial, None if end else ratio, state=end)
    assert studies.outcomes(study) == [
        Tried(0, 0.5, None, True),
        Tried(1, 0.1, None, False),
        Tried(2, 0.4, None, True),
    ]
    assert [trial.number for trial in studies.bests(study)] == [0, 2]


def test_every_design_meets_the_same_noise_and_divergence_is_the_worst():
    with _objective(payload=40.0, episodes=2, iterations=2) as objective:
        first, again = (list(objective.ratios(THESIS)) for _ in range(2))
    assert first == again
    assert len(first) == 2
    assert first[-1].seen < 1.0
    assert first[-1].true < 1.0
    bold = Design(gamma=(1.5,), delta=(0,), cutoff=(30.0,))
    with _objective(episodes=1, iterations=10) as objective:
        assert list(objective.ratios(bold))[-1] == Ratio(WORST, WORST)


def test_where_all_designs_diverge_there_is_no_best_one(armside, tmp_path, monkeypatch):
    """The storage keeps what was tried; no folder of results is made of it."""
    monkeypatch.setattr(tune_objective, "mean_ratio", lambda pairs: WORST)
    status, _, err = armside(f"tune {QUICK} --trials 6 --out a")
    assert status == 1
    assert err.splitlines()[-1].endswith("all 6 designs that were tried to the end diverged")
    assert "Warning" not in err
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize("sampler", ["random", "cmaes"])
def test_other_samplers_propose_designs(armside, sampler):
    assert armside(f"tune {QUICK} --quiet --trials 3 --sampler {sampler}").status == 0


def test_the_design_of_the_thesis_is_asked_for_until_it_was_tried(monkeypatch):
    """Neither a trial that failed nor one whose process was killed counts."""
    monkeypatch.setattr(study_storage, "SILENCE", -2)
    state = optuna.trial.TrialState
    study = optuna.create_study()
    for known, asked in (
        ({}, True),
        ({"state": state.FAIL}, True),
        ({"state": state.WAITING, "system_attrs": {"fixed_params": {"gamma": 0.9}}}, False),
        ({"state": state.RUNNING}, False),
        ({"state": state.PRUNED, "value": 0.5}, False),
        ({"state": state.COMPLETE, "value": 0.5}, False),
    ):
        study = optuna.create_study()
        if known:
            gamma = optuna.distributions.FloatDistribution(0.0, 1.0)
            waiting = known["state"] is state.WAITING
            tried = {"params": {"gamma": 0.9}, "distributions": {"gamma": gamma}}
            study.add_trial(optuna.trial.create_trial(**({} if waiting else tried), **known))
        before = len(study.trials)
        studies.ask_first(study, {"gamma": 0.9})
        assert (len(study.trials) > before) is asked, known


@pytest.mark.filterwarnings("ignore:Heartbeat of storage")
def test_the_thesis_design_is_tried_again_once_its_process_is_silent(tmp_path, monkeypatch):
    """A search that starts right after another was killed waits until that shows."""
    monkeypatch.setattr(study_storage, "HEARTBEAT", 1)
    monkeypatch.setattr(study_storage, "SILENCE", 1)
    url = f"sqlite:///{tmp_path}/a.db"
    study = open_study(url, "a", {}, sampler="tpe", pruner="none", seed=0)
    study.enqueue_trial({"gamma": 0.9})
    lost = study.ask()
    lost.suggest_float("gamma", 0.0, 1.0)
    with get_heartbeat_thread(lost._trial_id, study._storage):
        studies.ask_first(study, {"gamma": 0.9})
        assert [t.state.name for t in study.trials] == ["RUNNING"]
    studies.ask_first(study, {"gamma": 0.9})
    assert [t.state.name for t in study.trials] == ["FAIL", "WAITING"]
    assert study.ask().suggest_float("gamma", 0.0, 1.0) == 0.9


def test_a_search_that_is_interrupted_says_what_is_kept(armside, monkeypatch):
    def interrupted(study, objective, cfg, report, stop):
        study.optimize(lambda trial: 0.5, n_trials=1)
        raise KeyboardInterrupt

    monkeypatch.setattr(tune, "_search", interrupted)
    status, _, err = armside(f"tune {QUICK} --study a --storage sqlite:///b.db")
    assert status == 130
    assert "kept in study 'a' of 'sqlite:///b.db': 1" in err


def test_the_history_marks_what_lies_beyond_its_axis(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(tune_figures, "save", lambda figure, file: drawn.append(figure))
    tried = [Tried(0, 0.5, 0.6, True), Tried(1, 1e3, 1e3, True), Tried(2, 9.0, 8.0, True)]
    tune_figures.history(tmp_path / "a.png", tried, sees="as the motors see it")
    (axes,) = drawn[0].axes
    lines = {line.get_label(): line for line in axes.lines}
    assert axes.get_ylim()[1] > 9.0  # whatever is finite is inside
    assert list(lines["diverged, beyond the axis"].get_xdata()) == [1]
    assert list(lines["best so far, as the motors see it"].get_ydata()) == [0.5] * 3
    assert list(lines["the same design in truth"].get_ydata()) == [0.6] * 3


@pytest.mark.parametrize("ends", [(0.5, 0.4), (0.5, 1e3), (0.5, 0.4, 1e3, None)])
def test_the_legend_stands_on_the_axes_and_inside_the_picture(tmp_path, monkeypatch, ends):
    drawn = []
    monkeypatch.setattr(tune_figures, "save", lambda figure, file: drawn.append(figure))
    tried = [Tried(i, r or 0.9, r or 0.9, r is not None) for i, r in enumerate(ends)]
    tune_figures.history(tmp_path / "a.png", tried, sees="as the estimate sees it")
    (axes,) = drawn[0].axes
    drawn[0].canvas.draw()
    box, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
    gap = 0.2 * drawn[0].dpi  # less than a line of text
    assert 0.0 <= legend.y0 - box.y1 < gap
    assert 0.0 <= drawn[0].bbox.y1 - legend.y1 < gap
    assert drawn[0].bbox.x0 <= legend.x0 < legend.x1 <= drawn[0].bbox.x1


def test_each_motor_has_its_own_parameters():
    trial = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0)).ask()
    design = suggest(trial, Motors.EACH)
    assert len(trial.params) == 18
    assert design.gamma[3] == trial.params["gamma_4"]
    assert studies.parameters(design, Motors.EACH) == trial.params


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
        ("--robot irb1400 --reward estimate", "needs an open chain"),
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


def test_a_server_that_accepts_and_says_nothing_is_one_line_too(armside, monkeypatch):
    monkeypatch.setattr(study_storage, "CONNECT_TIMEOUT", 2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        url = f"postgresql+psycopg://a@127.0.0.1:{port}/b"
        began = time.monotonic()
        status, _, err = armside(f"tune {QUICK} --storage {url}")
    assert status == 2
    assert "does not answer" in err
    assert err.count("\n") == 1
    assert time.monotonic() - began < 30


def test_a_search_is_not_part_of_what_makes_studies_comparable():
    one, other = TuneCfg(trials=3, sampler="random"), TuneCfg(trials=9, pruner="none")
    assert _identity(one, 0) == _identity(other, 0)
    assert _identity(one, 0) != _identity(one, 1)


def test_a_password_is_not_shown(tmp_path):
    with pytest.raises(InputError, match=r"user:\*\*\*@127.0.0.1"):
        open_study(
            "postgresql+psycopg://user:secret@127.0.0.1:1/none",
            "a",
            {},
            sampler="tpe",
            pruner="none",
            seed=0,
        )


@pytest.fixture
def postgres(require_program, tmp_path):
    """URL of a PostgreSQL server of our own: its socket is in a temporary folder, no port is open.

    The server refuses to run as root; there it runs as the user `nobody`.
    """
    bin_folders = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    path = os.pathsep.join([*map(str, bin_folders), os.environ["PATH"]])
    initdb = shutil.which("initdb", path=path)
    if initdb is None:
        require_program("initdb")
    server = shutil.which("postgres", path=str(Path(initdb).parent))
    user = pwd.getpwnam("nobody") if os.geteuid() == 0 else None
    # Short and outside of pytest's folders, which another user may not enter; sockets have at most
    # 107 characters.
    folder = Path(subprocess.run(["mktemp", "-d"], capture_output=True, text=True).stdout.strip())
    run_as = {}
    if user is not None:
        os.chown(folder, user.pw_uid, user.pw_gid)
        run_as = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
    data = folder / "data"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder} | run_as
    subprocess.run([initdb, "-D", data, "-U", "armside", "-A", "trust"], check=True, **quiet)
    options = ["-k", str(folder), "-c", "listen_addresses=", "-c", "fsync=off"]
    process = subprocess.Popen([server, "-D", data, *options], **quiet)
    try:
        for _ in range(300):
            if (folder / ".s.PGSQL.5432").exists():
                break
            time.sleep(0.1)
        yield f"postgresql+psycopg://armside@/postgres?host={folder}"
    finally:
        process.send_signal(signal.SIGINT)  # "fast": does not wait for clients to leave
        process.wait(30)
        shutil.rmtree(folder)


def test_two_processes_share_one_study_in_postgresql(postgres, tmp_path):
    command = [sys.executable, "-m", "scripts.cli", "tune", *QUICK.split(), "--quiet"]
    command += ["--trials", "8", "--pruner", "none", "--study", "a", "--storage", postgres]
    running = [
        subprocess.Popen([*command, "--out", str(tmp_path / name)], cwd=Path.cwd())
        for name in ("a", "b")
    ]
    assert [process.wait(120) for process in running] == [0, 0]
    storage = optuna.storages.RDBStorage(postgres)
    known = optuna.load_study(study_name="a", storage=storage).trials
    storage.engine.dispose()
    trials = [t for t in known if t.state is optuna.trial.TrialState.COMPLETE]
    assert 8 <= len(trials) <= 9  # both may have been in their last trial
    assert sorted(t.number for t in known) == list(range(len(known)))
    tried = [tuple(sorted(t.params.items())) for t in trials]
    assert len(set(tried)) >= len(tried) - 1  # both may have begun with the thesis's design
