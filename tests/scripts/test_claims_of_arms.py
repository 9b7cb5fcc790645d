"""Claims about the estimate on other arms: where they fail, and one cut of each kind of arm."""

from pathlib import Path

import pytest

from armside.assets import IRB1400_XML
from armside.scripts.verifications import estimation_arms
from armside.scripts.verifications.estimation_arms import COLUMNS, LEFT, robot_files, row
from armside.sim.notes import Tally

from .verdicts import failing

pytestmark = pytest.mark.usefixtures("quick_identification")

HOLDING = dict.fromkeys(COLUMNS, 100.0) | {"start": 1000.0, "motor": 300.0}
TWO_LINK = IRB1400_XML.parent / "two_link.toml"


def with_rows(monkeypatch, changed, diverged=False):
    """Rows that hold, but for the last seed's at p3."""

    def measured(robot, pose, seed, _said):
        last = (pose, seed) == ("p3", 1)
        lengths = HOLDING | (changed if last else {})
        return seed, Path(robot).stem, pose, lengths, diverged and last

    monkeypatch.setattr(estimation_arms, "row", measured)


@pytest.mark.parametrize("claim", [estimation_arms.irb1400, estimation_arms.arms])
def test_claims_hold_for_rows_that_hold(claim, monkeypatch):
    with_rows(monkeypatch, {})
    assert failing(claim([0, 1])) == []


def test_one_cut_above_a_fifth_fails_the_irb1400(monkeypatch):
    with_rows(monkeypatch, {"learned": 1000.0 * LEFT - 0.1})
    table = estimation_arms.irb1400([0, 1])
    assert failing(table) == []
    assert "worst 0.200, median 0.100" in table.verdicts[0].statement
    with_rows(monkeypatch, {"learned": 1000.0 * LEFT + 0.1})
    (failed,) = failing(estimation_arms.irb1400([0, 1]))
    assert "at most 0.2 of k = 0" in failed


@pytest.mark.parametrize("claim", [estimation_arms.irb1400, estimation_arms.arms])
def test_one_cut_that_the_motors_learn_better_fails_its_robot_alone(claim, monkeypatch):
    with_rows(monkeypatch, {"motor": 99.0})
    failed = failing(claim([0, 1]))
    assert failed
    assert all("below motor side" in statement for statement in failed)


@pytest.mark.parametrize("claim", [estimation_arms.irb1400, estimation_arms.arms])
def test_one_divergence_fails(claim, monkeypatch):
    with_rows(monkeypatch, {}, diverged=True)
    (failed,) = failing(claim([0, 1]))
    assert failed == "no case diverges"


def test_every_robot_file_that_ships_is_judged():
    names = {file.name for file in robot_files()}
    assert TWO_LINK.name in names
    shipped = {file.name for file in IRB1400_XML.parent.glob("*.toml")}
    assert shipped - names == {"irb1400.toml", "large_robot.toml"}


def test_two_axes_learn_from_the_estimate_as_from_the_tracker():
    """An arm of two axes turns its tool as its position asks: no error of the program."""
    *_, lengths, diverged = row(str(TWO_LINK), "p1", 100, Tally())
    assert not diverged
    assert lengths["estimate"] < 0.1 * lengths["rigid"]
    assert lengths["learned"] < 0.05 * lengths["start"]
    assert lengths["learned"] < 1.2 * lengths["tracked"]
    assert lengths["learned"] < 0.5 * lengths["motor"]


def test_the_irb1400_learns_from_the_estimate():
    *_, lengths, diverged = row("irb1400", "p1", 100, Tally())
    assert not diverged
    assert lengths["estimate"] < 0.4 * lengths["rigid"]
    assert lengths["learned"] < LEFT * lengths["start"]
    assert lengths["learned"] < lengths["motor"]
