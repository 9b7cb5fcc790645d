"""`armside tune` interrupted: what is kept is said, and every thread ends."""

import signal
import subprocess
import sys
import threading
import time

import pytest

from armside.scripts.commands import tune
from armside.scripts.shell.interrupts import noticing
from armside.sim.laser.design import THESIS
from armside.sim.tuning.rules import Rules

from .quick_tuning import QUICK, objective_at_p1

pytestmark = pytest.mark.usefixtures("patient")


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
    assert process.stdout is not None
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
            assert stop.number
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
    with pytest.raises(RuntimeError), objective_at_p1(payload=40.0, episodes=2) as objective:
        next(objective.ratios(THESIS))
    monkeypatch.setattr(Rules, "first", broken)
    with pytest.raises(RuntimeError):
        objective_at_p1(payload=40.0, episodes=2)
    assert set(threading.enumerate()) == known
