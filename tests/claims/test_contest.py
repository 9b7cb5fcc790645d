"""The claim of the contest: rows that hold, and rows that fail one statement alone."""

import numpy as np
import pytest

from armside.sim.notes import Tally

from . import contest
from ._engine import Rows

LEVELS = {"thesis": 0.06, "good": 0.02, "nothing": 1.0, "random": 0.4, "cheat": 0.06}


def rows(second=None, public=0.02, judged=1.0):
    """Forty tasks of each entry in each round; `second` are levels of round 2."""
    rng = np.random.default_rng(0)
    noise = {which: np.exp(0.3 * rng.normal(size=40)) for which in contest.ROUNDS}
    found = []
    for entry, level in LEVELS.items():
        for which in contest.ROUNDS:
            of = (second or {}).get(entry, level) if which == "2" else level
            if entry == "cheat":
                of = public if which == "public" else level * judged
            for task, factor in enumerate(noise[which]):
                about = {"track": "joint", "entry": entry, "round": which, "task": task}
                found.append({**about, "left": of * factor, "harm": False})
    return Rows(found)


@pytest.mark.parametrize(
    ("change", "fails"),
    [
        ({}, ()),
        ({"second": {"good": 0.05}}, ("interval of a difference",)),
        ({"second": {"good": 0.07}}, ("interval of a difference", "keep their order")),
        ({"public": 0.06}, ("the cheat leaves less",)),
        ({"judged": 0.9}, ("gains nothing in judged round 1", "gains nothing in judged round 2")),
    ],
)
def test_a_row_of_the_contest_beyond_its_bar_fails_that_statement_alone(change, fails):
    failed = [check.statement for check in contest.checks(rows(**change)) if not check.holds]
    assert len(failed) == len(fails)
    for statement, words in zip(failed, fails, strict=True):
        assert words in statement


def test_a_slice_of_the_contest_is_played(monkeypatch):
    monkeypatch.setattr(contest, "TASKS", 2)
    cases = [(0, ("joint", name)) for name in ("nothing", "thesis", "cheat")]
    found = Rows(row for case in cases for row in contest.run(case, Tally()))
    assert len(found) == 2 * 2 + 2 * 2 * 3  # public tasks for the cheat and the thesis's design
    by = {key: of["left"] for key, of in found.by("entry").items()}
    assert by["nothing"] == pytest.approx(1.0, abs=0.02)
    sealed = {
        name: found.by("entry")[name].by("round")["1"]["left"] for name in ("cheat", "thesis")
    }
    assert np.array_equal(sealed["cheat"], sealed["thesis"])
    public = {name: found.by("entry")[name].by("round")["public"] for name in ("cheat", "thesis")}
    assert (public["cheat"]["left"] < 0.7 * public["thesis"]["left"]).all()
    assert len(list(contest.shown(found))) == 2 + 3 + 3
