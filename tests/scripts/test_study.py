"""Studies of `armside tune` and their database: shared, resumed, and what is wrong with it."""

import os
import pwd
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import optuna
import pytest
from optuna.storages._heartbeat import get_heartbeat_thread
from sqlalchemy.exc import OperationalError

from armside.scripts.commands import tune
from armside.scripts.shell.errors import InputError
from armside.scripts.studies import storage as study_storage
from armside.scripts.studies import study as studies
from armside.scripts.studies.search import run_trial
from armside.scripts.studies.storage import redacted, using
from armside.scripts.studies.study import Outcome, open_study, suggest
from armside.sim.tuning.action import Motors

from .quick_tuning import QUICK, opened

pytestmark = pytest.mark.filterwarnings("ignore:Heartbeat of storage")


def test_a_design_that_learns_slowly_is_not_given_up_early(tmp_path):
    study = opened(tmp_path, sampler="random", pruner="percentile")
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


def test_a_sampler_is_the_one_that_is_named():
    for name, kind in (("random", "Random"), ("cmaes", "CmaEs"), ("tpe", "TPE")):
        study = optuna.create_study(sampler=studies.new_sampler(name, 0))
        study.ask()
        assert type(study.sampler._of_trial) is getattr(optuna.samplers, f"{kind}Sampler")


def test_a_design_that_was_given_up_is_never_the_best():
    ends = {0.5: None, 0.1: optuna.trial.TrialState.PRUNED, 0.4: None}
    study = optuna.create_study()
    for ratio, end in ends.items():
        trial = study.ask()
        trial.report(ratio, 3)
        study.tell(trial, None if end else ratio, state=end)
    assert studies.outcomes(study) == [
        Outcome(0, 0.5, None, True),
        Outcome(1, 0.1, None, False),
        Outcome(2, 0.4, None, True),
    ]
    assert [trial.number for trial in studies.bests(study)] == [0, 2]


def test_the_design_of_the_thesis_is_asked_for_until_it_was_tried(monkeypatch):
    """Neither a trial that failed nor one whose process was killed counts."""
    monkeypatch.setattr(studies, "SILENCE", -2)
    state = optuna.trial.TrialState
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


def test_the_thesis_design_is_tried_again_once_its_process_is_silent(tmp_path, monkeypatch):
    """A search that starts right after another was killed waits until that shows."""
    monkeypatch.setattr(study_storage, "HEARTBEAT", 1)
    for module in (study_storage, studies):
        monkeypatch.setattr(module, "SILENCE", 1)
    study = opened(tmp_path)
    study.enqueue_trial({"gamma": 0.9})
    lost = study.ask()
    lost.suggest_float("gamma", 0.0, 1.0)
    with get_heartbeat_thread(lost._trial_id, study._storage):
        studies.ask_first(study, {"gamma": 0.9})
        assert [t.state.name for t in study.trials] == ["RUNNING"]
    studies.ask_first(study, {"gamma": 0.9})
    assert [t.state.name for t in study.trials] == ["FAIL", "WAITING"]
    assert study.ask().suggest_float("gamma", 0.0, 1.0) == 0.9


DIES = """
import os, sys
from armside.scripts.studies.study import open_study

def dies(trial):
    trial.suggest_float("gamma", 0.0, 1.0)
    storage = trial.study._storage  # its thread may be late with the first heartbeat
    getattr(storage, "_backend", storage).record_heartbeat(trial._trial_id)
    os.kill(os.getpid(), 9)

open_study(sys.argv[1], "a", {}, sampler="tpe", pruner="none", seed=0).optimize(dies, n_trials=1)
"""


def test_the_design_of_a_killed_process_is_tried_again_once_it_is_silent(tmp_path, monkeypatch):
    url = f"sqlite:///{tmp_path}/a.db"
    assert subprocess.run([sys.executable, "-c", DIES, url], check=False).returncode == -9
    monkeypatch.setattr(study_storage, "HEARTBEAT", 1)
    monkeypatch.setattr(study_storage, "SILENCE", 1)
    study = opened(tmp_path)
    time.sleep(2.5)  # the database counts whole seconds
    run_trial(study, lambda trial: trial.suggest_float("gamma", 0.0, 1.0))
    dead, again = study.trials
    assert (dead.state.name, again.state.name) == ("FAIL", "COMPLETE")
    assert again.params == dead.params


def test_each_motor_has_its_own_parameters():
    trial = optuna.create_study(sampler=optuna.samplers.RandomSampler(seed=0)).ask()
    design = suggest(trial, Motors.EACH)
    assert len(trial.params) == 18
    assert design.gamma[3] == trial.params["gamma_4"]
    assert studies.parameters(design, Motors.EACH) == trial.params


def test_a_database_of_another_program_is_refused_and_left_as_it_was(armside, tmp_path):
    with closing(sqlite3.connect(tmp_path / "a.db")) as database:
        database.execute("CREATE TABLE studies (title TEXT)")
        database.commit()
        status, _, err = armside(f"tune {QUICK} --storage sqlite:///a.db")
        tables = database.execute("SELECT name FROM sqlite_master").fetchall()
    assert status == 2
    assert "belongs to another program: its table 'studies' is none of Optuna's" in err
    assert err.count("\n") == 1
    assert tables == [("studies",)]


def test_what_is_waited_for_is_said_and_then_what_was_wrong(armside, tmp_path, monkeypatch):
    monkeypatch.setattr(study_storage, "SLOW", 0.2)
    monkeypatch.setattr(study_storage, "LOCK_TIMEOUT", 0.5)
    with closing(sqlite3.connect(tmp_path / "a.db", isolation_level=None)) as database:
        database.execute("BEGIN EXCLUSIVE")
        status, _, err = armside(f"tune {QUICK} --storage sqlite:///a.db")
    assert status == 2
    waiting, wrong = err.splitlines()
    assert waiting == "armside: waiting for storage 'sqlite:///a.db'"
    assert "storage 'sqlite:///a.db' does not answer: database is locked" in wrong


def drop_table(file):
    with closing(sqlite3.connect(file)) as database:
        database.execute("DROP TABLE trials")


def remove(file):
    file.unlink()
    file.mkdir()


@pytest.mark.parametrize(
    ("lose", "said"),
    [
        (drop_table, "no such table: trials"),
        (lambda file: file.write_bytes(b"no database" * 1000), "file is not a database"),
        (remove, "unable to open database file"),
    ],
)
def test_a_storage_that_is_lost_is_one_line(armside, tmp_path, monkeypatch, lose, said):
    def lost(study, *_, **__):
        lose(tmp_path / "a.db")
        study._storage.remove_session()
        study._storage._backend.engine.dispose()
        study.get_trials()

    monkeypatch.setattr(tune, "search", lost)
    status, _, err = armside(f"tune {QUICK} --storage sqlite:///a.db")
    assert status == 1
    assert f"storage 'sqlite:///a.db' failed: {said}" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("name", ["{a}.db", "50%.db"])
def test_a_file_may_have_any_name(tmp_path, name):
    open_study(f"sqlite:///{tmp_path}/{name}", "a", {}, sampler="tpe", pruner="none", seed=0)
    assert (tmp_path / name).exists()


def test_of_two_processes_that_begin_together_the_one_with_another_task_is_refused(tmp_path):
    """The study may be there before what it tunes is."""
    url = f"sqlite:///{tmp_path}/a.db"
    study = optuna.create_study(storage=url, study_name="a")
    writer = threading.Timer(0.5, study.set_user_attr, ["config", {"task": "theirs"}])
    writer.start()
    with pytest.raises(InputError, match="tunes something else: task differ"):
        opened(tmp_path, {"task": "ours"})
    writer.join()
    assert study.user_attrs["config"] == {"task": "theirs"}


def test_a_study_without_a_task_gets_one(tmp_path, monkeypatch):
    """The process that has made it was killed before it could say."""
    monkeypatch.setattr(studies, "CONFIG_TIMEOUT", 0.0)
    url = f"sqlite:///{tmp_path}/a.db"
    optuna.create_study(storage=url, study_name="a")
    ours = opened(tmp_path, {"task": "ours"})
    assert ours.user_attrs["config"] == {"task": "ours"}


def test_a_server_that_accepts_and_says_nothing_is_one_line_too(bad_input, monkeypatch):
    monkeypatch.setattr(study_storage, "CONNECT_TIMEOUT", 2)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        url = f"postgresql+psycopg://a@127.0.0.1:{port}/b"
        bad_input(f"tune {QUICK} --storage {url}", "does not answer")


@pytest.mark.parametrize(
    ("storage", "shown"),
    [
        ("postgresql+psycopg://u:secret@host:1/none", "postgresql+psycopg://u:***@host:1/none"),
        ("postgresql://user:sec/r@et@host/b", "postgresql://user:***@host/b"),
        ("mysql://a@/b?host=/tmp&PassWord=secret", "mysql://a@/b?PassWord=***&host=/tmp"),
        ("mysql://a/b?p%61sswd=secret&charset=utf8", "mysql://a/b?charset=utf8&passwd=***"),
        ("mssql:///?odbc_connect=UID=a;PWD=secret", "mssql:///?odbc_connect=***"),
        ("postgresql://user:sec?ret@host/b", "postgresql://user:***@host/b"),
        ("postgresql:user:secret@host/b", "***"),
        ("runs/a.db", "runs/a.db"),
        ("postgresql://[::1]:5432/b", "postgresql://[::1]:5432/b"),
        ("sqlite:///runs/a:b.db", "sqlite:///runs/a:b.db"),
    ],
)
def test_what_is_secret_in_a_storage_is_not_shown(storage, shown):
    assert redacted(storage) == shown


def test_a_password_is_in_no_error(bad_input):
    storage = "postgresql+psycopg://user:secret@127.0.0.1:1/none?sslpassword=secret"
    assert "secret" not in bad_input(f"tune {QUICK} --storage {storage}", "user:***@127.0.0.1:1")


def test_a_password_is_in_no_result(armside, tmp_path, monkeypatch):
    def local(storage, *args, **options):
        return open_study("sqlite://", *args, **options)

    monkeypatch.setattr(studies, "open_study", local)
    storage = "postgresql://user:secret@host/b"
    line = f"tune {QUICK} --trials 1 --storage {storage} --out"
    printed = [armside(f"{line} a").out, armside(f"{line} b --json").out]
    written = (tmp_path / "a" / "summary.json").read_text()
    for text in (*printed, written):
        assert "user:***@host" in text
        assert "secret" not in text


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


def command(storage, more):
    words = f"tune {QUICK} --quiet --study a --storage {storage} {more}".split()
    return [sys.executable, "-m", "armside.scripts.cli", *words]


def test_two_processes_share_one_study_in_postgresql(postgres, tmp_path):
    words = command(postgres, "--trials 4 --pruner none")
    running = [
        subprocess.Popen([*words, "--out", str(tmp_path / name)], cwd=Path.cwd())
        for name in ("a", "b")
    ]
    assert [process.wait(120) for process in running] == [0, 0]
    storage = optuna.storages.RDBStorage(postgres)
    known = optuna.load_study(study_name="a", storage=storage).trials
    storage.engine.dispose()
    trials = [t for t in known if t.state is optuna.trial.TrialState.COMPLETE]
    assert 4 <= len(trials) <= 5  # both may have been in their last trial
    assert sorted(t.number for t in known) == list(range(len(known)))
    tried = [tuple(sorted(t.params.items())) for t in trials]
    assert len(set(tried)) >= len(tried) - 1  # both may have begun with the thesis's design


def test_a_server_that_goes_away_in_mid_study_is_one_line(postgres, tmp_path):
    """Its finished trials stay in it."""
    words = command(postgres, "--trials 1000")
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        storage = optuna.storages.RDBStorage(postgres)
        for _ in range(600):
            if any(study.n_trials > 2 for study in optuna.get_all_study_summaries(storage)):
                break
            time.sleep(0.1)
        storage.engine.dispose()
        (mark,) = Path(postgres.partition("host=")[2]).glob("**/postmaster.pid")
        os.kill(int(mark.read_text().split()[0]), signal.SIGQUIT)
        _, err = running.communicate(timeout=120)
    assert running.returncode == 1
    last = err.splitlines()[-1]
    assert last.startswith("armside: ")
    assert last.endswith("it keeps finished trials")
    assert all(line.startswith("armside: waiting") for line in err.splitlines()[:-1])


def test_a_mode_that_sqlite_would_not_see_is_refused_and_nothing_is_made(bad_input):
    said = "?mode= is part of an SQLite URI: sqlite:///file:a.db?mode=ro&uri=true"
    bad_input(f"tune {QUICK} --storage sqlite:///a.db?mode=ro", said)


def test_a_pool_that_loses_its_server_prints_no_traceback(tmp_path):
    code = f"""
import logging
from armside.scripts.studies.storage import connect
connect("sqlite:///{tmp_path}/a.db")
logging.getLogger("sqlalchemy.pool.impl.QueuePool").error("Exception during reset or similar")
"""
    command = [sys.executable, "-c", code]
    assert subprocess.run(command, capture_output=True, check=True).stderr == b""


@pytest.mark.parametrize(
    ("error", "printed"), [(OperationalError("", {}, OSError()), False), (KeyError("ours"), True)]
)
def test_a_heartbeat_that_loses_its_server_prints_no_traceback(error, printed, monkeypatch):
    seen = []
    monkeypatch.setattr(threading, "excepthook", seen.append)

    def beat():
        raise error

    with using("sqlite:///a.db"):
        heartbeat = threading.Thread(target=beat)
        heartbeat.start()
        heartbeat.join()
    assert len(seen) == printed
    assert threading.excepthook == seen.append
