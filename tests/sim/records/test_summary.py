"""`summary.json` is strict JSON that keeps every bit."""

import json
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armside.scripts.shell.console import Report
from armside.scripts.shell.options import Common
from armside.sim.records.summary import dumps, summary


class Shape(Enum):
    CIRCLE = "circle"


@dataclass(frozen=True)
class Cfg:
    shape: Shape = Shape.CIRCLE
    radius: float = 0.1
    model: Path = Path("a/b.xml")


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_floats_come_back_bit_for_bit(values):
    back = json.loads(dumps({"e": np.array(values)}))["e"]
    assert np.array(back, dtype=float).tobytes() == np.array(values, dtype=float).tobytes()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, np.float32("nan")])
def test_what_is_not_finite_is_null(value):
    assert json.loads(dumps({"e": [value, 1.0]})) == {"e": [None, 1.0]}


def test_the_configuration_holds_options_seed_and_versions():
    found = summary("laser", Cfg(), Common(seed=3), status="diverged", iterations=[{"k": 0}])
    config = found["config"]
    assert config["experiment"] == "laser"
    assert config["shape"] == "circle"
    assert config["model"] == "a/b.xml"
    assert config["seed"] == 3
    assert config["versions"]["numpy"] == np.__version__
    assert found["status"] == "diverged"
    assert found["iterations"] == [{"k": 0}]


def test_what_json_cannot_hold_is_an_error_and_not_a_string():
    with pytest.raises(TypeError, match="set"):
        dumps({"e": {1, 2}})


def test_a_command_without_files_writes_only_where_it_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Report(Common()).kept(summary("bench", {}, Common()))
    assert not list(tmp_path.iterdir())
    Report(Common(out=tmp_path / "a")).kept(summary("bench", {}, Common()))
    assert json.loads((tmp_path / "a" / "summary.json").read_text())["status"] == "done"
