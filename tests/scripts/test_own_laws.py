"""A law of the user's own reaches neither streams, folder, modules nor the end of the process."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from armside.scripts.cli import main

LAWS = """
import os, subprocess, sys

def prints(u, e):
    print("from Python")
    sys.stdout.close()
    os.write(1, b"from the system\\n")
    subprocess.run(["echo", "from a program"], check=True)
    return u + 0.5 * e

def moves(u, e):
    os.chdir("/")
    return u + 0.5 * e

def forgets(u, e):
    sys.modules.clear()
    return u + 0.5 * e

def replaces(u, e):
    sys.modules["json"] = sys.modules["pathlib"] = None
    sys.stdout = sys.stderr = None
    return u + 0.5 * e

def leaves(u, e):
    sys.exit(0)

def generates(u, e):
    raise GeneratorExit

def ends(u, e):
    os._exit(0)

def becomes(u, e):
    os.execv("/bin/true", ["true"])

def breaks(u, e):
    sys.modules.clear()
    raise ValueError("broken")

class Nesterov:
    def __init__(self, gain=1.0, delta=0):
        self.gain, self.delta = gain, delta
    def __call__(self, u, e):
        assert (self.gain, self.delta) == (0.8, 1)
        return u + self.gain * e
"""


@pytest.fixture
def law(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(LAWS)
    return lambda name: ["learn", "--iterations", "1", "--json", "--laws", f"own.py:{name}"]


@pytest.mark.parametrize("name", ["prints", "moves", "forgets", "replaces"])
def test_a_law_changes_neither_the_json_nor_the_place_of_the_results(name, law, capfd, tmp_path):
    loaded = dict(sys.modules)
    assert main(law(name)) == 0
    out, err = capfd.readouterr()
    assert json.loads(out)["status"] == "done"
    assert len(list((tmp_path / "runs").glob("learn*"))) == 1
    assert loaded.items() <= sys.modules.items()
    if name == "prints":
        for source in ("Python", "the system", "a program"):
            assert f"from {source}\n" in err


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("leaves", "SystemExit: 0"),
        ("generates", "GeneratorExit"),
        ("ends", "RuntimeError: os._exit would end armside"),
        ("becomes", "RuntimeError: os.execv would end armside"),
        ("breaks", "ValueError: broken"),
    ],
)
def test_a_law_that_ends_the_process_or_breaks_it_is_one_line_and_status_1(name, said, law):
    lines = LAWS.splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith(f"def {name}("))
    line = at + next(i for i, line in enumerate(lines[at:]) if not line)
    done = subprocess.run(
        [sys.executable, "-m", "armside.scripts.cli", *law(name)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"armside: own.py, line {line}: {said}\n"
    assert not Path("runs").exists()


@pytest.mark.parametrize("words", ["gain=0.8:delta=1", "gain=0.8,delta=1", "gain=0.8 : delta=1"])
def test_numbers_of_a_law_are_numbers_however_they_are_parted(words, law):
    assert main(law(f"Nesterov:{words}")) == 0
