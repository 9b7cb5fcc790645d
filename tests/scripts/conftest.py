"""The probe experiment, run in this process or in one of its own."""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.results_listed import command_of, fields, unlisted

from armside.scripts import cli
from armside.scripts.figures import canvas
from armside.scripts.jobs.dataset import Dataset
from armside.scripts.jobs.grid import parse, run_grid
from armside.scripts.studies import storage
from armside.scripts.thesis.report import Section
from armside.sim.records import summary as written

from .sweep_engine import AXES, Serial

HERE = Path(__file__).parent
START = f"""
import sys
sys.path.insert(0, {str(HERE)!r})
from armside.scripts import cli
from probe_experiment import load
cli.COMMANDS["probe"], cli.load = ("Look", "End as told to."), load
sys.exit(cli.main())
"""


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


@pytest.fixture
def armside(monkeypatch, tmp_path, capsys):
    """Runs a command line in this process, in an empty working folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(HERE)
    monkeypatch.setitem(cli.COMMANDS, "probe", ("Look", "End as told to."))
    monkeypatch.setattr(cli, "load", importlib.import_module("probe_experiment").load)

    def run(line: str) -> Outcome:
        status = cli.main(line.split())
        return Outcome(status, *capsys.readouterr())

    return run


@pytest.fixture
def summary_of(armside):
    """Runs a command line that is done, as `armside`; its summary as it is printed."""

    def run(line: str) -> dict[str, Any]:
        status, out, err = armside(f"{line} --json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return run


@pytest.fixture
def bad_input(armside, tmp_path):
    """Checks that a command line is refused with one clear line, and that nothing is written."""

    def check(line: str, said: str) -> str:
        before = sorted(tmp_path.rglob("*"))
        status, out, err = armside(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert err.startswith("armside: ")
        assert said in err
        assert sorted(tmp_path.rglob("*")) == before
        return err

    return check


@pytest.fixture
def armside_process(tmp_path):
    """Runs a command line in a process of its own, in an empty working folder."""

    def run(line: str, **options) -> Outcome:
        command = [sys.executable, "-c", START, *line.split()]
        env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        env["PYTHONDONTWRITEBYTECODE"] = "1"  # a limit of file sizes cuts that of our modules short
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
        done = subprocess.run(
            command, cwd=tmp_path, env=env, text=True, timeout=60, check=False, **streams
        )
        return Outcome(done.returncode, done.stdout or "", done.stderr or "")

    return run


@pytest.fixture
def assert_complete():
    """Says of a section of a report that it is captioned, drawn into a folder, and whole."""

    def check(section: Section, folder: Path) -> None:
        assert len(section.caption) > 40
        assert section.figures or section.tables
        for file in section.figures:
            assert (folder / file).read_bytes().startswith(b"\x89PNG")
        assert all(np.isfinite(check.ours) for check in section.checks)

    return check


@pytest.fixture
def drawn(monkeypatch):
    """Figures that would have been saved."""
    found = []
    monkeypatch.setattr(canvas, "save", lambda figure, file: found.append(figure))
    return found


@pytest.fixture
def patient(monkeypatch):
    """A busy machine may take seconds to open a storage, which is then announced."""
    monkeypatch.setattr(storage, "SLOW", 60.0)


@pytest.fixture(scope="session")
def whole(made_once):
    """The dataset of AXES, computed in one process without any disturbance."""

    def make(folder):
        counts = run_grid(parse(AXES, 0), Dataset(folder), Serial())
        assert counts == {"done": 4, "failed": 4}

    return Dataset(made_once("whole", make)).read()


@pytest.fixture(scope="session")
def replayed(made_once):
    """Folder with a run of two iterations, `two`, and its replay, `two.rrd`."""

    def make(folder):
        out, file = folder / "two", folder / "two.rrd"
        assert cli.main(["laser", "--iterations", "1", "--quiet", "--out", str(out)]) == 0
        assert cli.main(["replay", str(out), "--save", str(file), "--quiet"]) == 0

    return made_once("replayed", make)


@pytest.fixture(scope="session", autouse=True)
def results_are_in_the_table():
    """Each summary that any test here lets a command write has no field that the table lacks."""
    plain, missing, commands = written.plain, set[str](), set(cli.COMMANDS)

    def looked_at(value):
        if isinstance(value, dict) and {"format", "config", "status"} <= value.keys():
            of = command_of(value)
            missing.update(unlisted(of, fields(plain(value))) if of.split()[0] in commands else ())
        return plain(value)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(written, "plain", looked_at)
        yield
    assert not missing, "tests/results_tested.toml lacks these"
