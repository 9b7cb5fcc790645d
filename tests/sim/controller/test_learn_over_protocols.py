"""`armside learn` on a robot behind a protocol: a law of a paper, and updates in two parts."""

import json
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from armside.ilc.workbench.signals import write_signal
from armside.scripts.cli import main
from armside.sim.controller.client import Rsi
from armside.sim.controller.egm import EgmWire
from armside.sim.controller.rsi import RsiWire
from armside.sim.controller.server import Server

from .robots import guided, path, programmed, served

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
PATIENCE = 20.0


@contextmanager
def speaking(protocol):
    """The small robot, speaking to a free port; yields the words of the plant."""
    wire, controller = (EgmWire(), guided()) if protocol == "egm" else (RsiWire(), programmed())
    with Rsi(port=0) as link:
        port = link.address[1]
    with served(Server(controller, wire, ("127.0.0.1", port), patience=PATIENCE)):
        yield f"{protocol}:port={port},wait=20"


def learned(*words):
    assert main(["learn", *map(str, words), "--quiet"]) == 0
    folder = Path(words[-1])
    return json.loads((folder / "summary.json").read_text())


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_signal(tmp_path / "path.csv", path(), 0.004, "r")
    return tmp_path


def test_a_model_free_law_of_a_paper_learns_two_axes_through_egm(place):
    """Every pair of axes by time reversal: four runs of the robot an update."""
    law = f"{EXAMPLES / 'adjoint.py'}:Adjoint"
    with speaking("egm") as plant:
        words = ("--plant", plant, "--reference", "path.csv", "--laws", law, "--iterations", 2)
        steps = ("--beyond", "speed", "acceleration")  # errors backwards begin with one
        (row,) = learned(*words, *steps, "--out", "a")["laws"]
    assert row["error_two"][-1] < 0.7 * row["error_two"][0]
    assert not row["diverged"]


@pytest.mark.parametrize("protocol", ["egm", "rsi"])
def test_updates_and_as_many_more_over_a_protocol_are_those_at_once(protocol, place):
    n, law = 2, "heuristic:gamma=0.7,delta=6,cutoff=15"
    of_path = ("--reference", "path.csv") if protocol == "egm" else ()
    steps = ("--beyond", "speed", "acceleration")  # the path moves at once
    with speaking(protocol) as plant:
        words = ("--plant", plant, *of_path, "--laws", law, *steps)
        whole = learned(*words, "--iterations", 2 * n, "--out", "once")
    with speaking(protocol) as plant:
        words = ("--plant", plant, *words[2:])
        learned(*words, "--iterations", n, "--out", "first")
        more = learned("--from", "first", *steps, "--iterations", n, "--out", "more")
    assert more["started_from"]["how"] == "its last runs"
    assert more["laws"][0]["error_two"] == whole["laws"][0]["error_two"][n + 1 :]
    names = [next(Path(name).glob("correction-1-*.csv")) for name in ("once", "more")]
    assert names[0].read_bytes() == names[1].read_bytes()


def test_a_start_beyond_the_gate_is_refused_and_so_is_a_law_that_grows_there(place, capsys):
    """Bad input before anything is sent; a failure where the law comes to it, in one line each."""
    write_signal(place / "wild.csv", np.full_like(path(), 1e6), 0.004, "correction")
    with speaking("rsi") as plant:
        words = ["learn", "--plant", plant, "--iterations", "3", "--quiet", "--out", "a"]
        assert main([*words, "--from", "wild.csv"]) == 2
        assert main([*words, "--laws", "heuristic:gamma=100,delta=0,cutoff=15"]) == 1
    start, grown = capsys.readouterr().err.splitlines()
    for said in (start, grown):
        assert said.startswith("armside: size: the correction of axis 1 must be within 5 deg")
        assert said.endswith("lets it through; nothing was sent")
    assert not (place / "a").exists()
