"""Storages of `armside tune` that cannot be had."""

import subprocess
import sys
import threading

import pytest
from sqlalchemy.exc import OperationalError

from armside.scripts.studies.storage import using

QUICK = "--pose p1 --speed 60 --payload 40 --episodes 1 --iterations 1"


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
