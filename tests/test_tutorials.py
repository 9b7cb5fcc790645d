"""The tutorials of the docs run in one namespace each, and come out as they say.

`make docs` runs them as notebooks. In CI they run here as they stand; else the twin is the one that
other tests share, of one cut.
"""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.conftest import WHOLE
from tests.test_surface import FOLDERS, declared, imports

ROOT = Path(__file__).parent.parent
NOTEBOOKS = {file.stem: file for file in sorted((ROOT / "docs/tutorials").glob("*.ipynb"))}
DEEPER = {
    "first-cut-right": {
        ("armside.sim.robot.spread", "Drawn"),
        ("armside.sim.twin.commission", "plan"),
        ("armside.sim.twin.commission", "recorded"),
    }
}
"""What stands for a real robot and its recordings: deeper than what is declared."""


def cells(name, kind):
    """Sources of the cells of a kind."""
    content = json.loads(NOTEBOOKS[name].read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in content["cells"] if cell["cell_type"] == kind]


@pytest.fixture
def ran(monkeypatch):
    """A function that runs a notebook where it lies and returns its names."""
    monkeypatch.chdir(ROOT / "docs/tutorials")
    monkeypatch.setattr(plt.rcParams, "backend", "agg", raising=False)

    def run(name, small=("", "")):
        names = {"__name__": "__main__"}
        for i, source in enumerate(cells(name, "code")):
            text = source if WHOLE else source.replace(*small)
            exec(compile(text, f"{name}, cell {i}", "exec"), names)
        return names

    yield run
    plt.close("all")


def test_there_are_four_and_the_site_lists_them():
    assert set(NOTEBOOKS) == {"why-motors-lie", "my-own-law", "first-cut-right", "a-real-ur10"}
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    assert all(index.count(f"tutorials/{name}\n") == 1 for name in NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_stored_short_and_without_results(name):
    content = json.loads(NOTEBOOKS[name].read_text(encoding="utf-8"))
    code = [cell for cell in content["cells"] if cell["cell_type"] == "code"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    assert len(code) <= 12
    assert "minute" in cells(name, "markdown")[0]


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_imports_declared_names(name):
    handed_on = {(package, each) for package in FOLDERS for each in declared(package)}
    assert imports("\n".join(cells(name, "code"))) - handed_on == DEEPER.get(name, set())


def test_motors_follow_and_the_tool_does_not(ran):
    made = ran("why-motors-lie")
    assert made["motor"][-1] < 0.05 * made["motor"][0]
    assert made["rigid"][-1] < 0.1 * made["rigid"][0]
    assert made["tool"][-1] > made["tool"][0]
    assert made["cured"][-1] < 0.1 * made["cured"][0]


def test_the_criterion_tells_laws_that_learn_from_one_that_does_not(ran):
    made = ran("my-own-law")
    assert {name: v.is_met for name, v in made["verdicts"].items()} == {
        "bold": False,
        "careful": True,
        "ahead": True,
    }
    for name, sizes in made["robot"].items():
        assert (sizes[-1] < 1.0) == (name != "bold"), name
        # Of the same order: the model is one lag for all motors, without friction.
        np.testing.assert_allclose(made["predicted"][name][-1], sizes[-1], rtol=0.25)


def test_the_first_cut_of_a_new_part_is_right(ran):
    made = ran("first-cut-right", small=("CUTS = 2", "CUTS = 1"))
    assert made["correction"].trusted
    assert made["after"] < 0.1 * made["before"]
    assert made["found"].low < made["found"].expected < made["found"].high
    assert made["after"] < made["found"].high
    assert made["found"].calibrated is WHOLE  # by one cut it is no interval of 90 %


def test_a_real_arm_is_better_than_its_data_sheet(ran):
    made = ran("a-real-ur10")
    mean = {name: error.mean for name, error in made["errors"].items()}
    assert mean["full"] < 0.5 * mean["geometry"]
    assert mean["geometry"] < 0.6 * mean["nominal"]
    assert made["text"].startswith('name = "UR10 calibrated"')


def test_without_its_measurements_a_notebook_says_where_they_go(ran, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"examples/ur10_tmac: put .* from Series_C of"):
        ran("a-real-ur10")
