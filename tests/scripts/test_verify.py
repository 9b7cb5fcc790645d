"""A claim over many seeds becomes a page of the docs, and its verdict an exit status."""

import json

import pytest

from armside.scripts.commands import verify
from armside.scripts.verifications.claims import CLAIMS, Claim
from armside.sim.evaluation.check import Check, Table, all_hold, over_seeds


def claim(seeds):
    rows = [[seed, 0.5 * seed] for seed in seeds]
    return Table(
        "Errors stay small",
        ["seed", "error"],
        rows,
        [all_hold("every error is below 1", [error < 1.0 for _, error in rows])],
    )


@pytest.fixture
def one_claim(monkeypatch):
    monkeypatch.setattr(verify, "CLAIMS", {"small": Claim(2, lambda: claim)})


def test_a_claim_that_holds_writes_its_page(armside, one_claim, tmp_path):
    status, out, err = armside("verify small")
    assert (status, err) == (0, "")
    assert "holds: every error is below 1" in out
    page = (tmp_path / "docs" / "verify-small.md").read_text()
    assert page.startswith("# Errors stay small\n")
    assert "armside verify small --seeds 2 --seed 0" in page
    assert "| 1 | 0.5 |" in page
    assert "- holds: every error is below 1" in page


def test_the_same_seeds_write_the_same_page(armside, one_claim, tmp_path):
    armside("verify small --quiet --docs a")
    armside("verify small --quiet --docs b")
    pages = [(tmp_path / folder / "verify-small.md").read_bytes() for folder in "ab"]
    assert pages[0] == pages[1]


def test_a_claim_that_fails_writes_its_page_too_and_ends_with_status_1(
    armside, one_claim, tmp_path
):
    status, out, err = armside("verify small --seeds 3")
    assert status == 1
    assert "every error is below 1" in err
    assert "FAILS: every error is below 1" in out
    assert "**fails**: every error is below 1" in (tmp_path / "docs/verify-small.md").read_text()


def test_seeds_count_up_from_the_seed(armside, one_claim, tmp_path):
    status, out, _ = armside("verify small --seed 5 --seeds 1 --json --out kept")
    assert status == 1
    summary = json.loads(out)
    assert summary["table"]["rows"] == [[5, 2.5]]
    assert summary["status"] == "failed"
    assert json.loads((tmp_path / "kept" / "summary.json").read_text()) == summary


def test_a_row_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="1 cells for 2 columns"):
        Table("t", ["a", "b"], [[1]], [])


@pytest.mark.parametrize("name", CLAIMS)
def test_every_claim_can_be_loaded(name):
    assert callable(CLAIMS[name].load())


@pytest.mark.parametrize(("fraction", "holds"), [(1.0, False), (0.75, True)])
def test_a_check_must_hold_for_a_fraction_of_the_seeds(fraction, holds):
    by_seed = {seed: [Check("a", "error", "small", seed, high=2.0)] for seed in range(4)}
    table = over_seeds("Errors", by_seed, fraction)
    assert table.rows == [("a", "error", "small", "≤ 2", 0.0, 1.0, 2.0, 3.0, "3 of 4")]
    (verdict,) = table.verdicts
    assert verdict.holds is holds
    assert "(3 of 4)" in verdict.statement


def test_exceptions_to_a_statement_are_counted():
    assert all_hold("all", [True, True]).holds
    assert all_hold("all", [[True, False], [False, True]]).ours == 2.0
    assert not all_hold("one", False).holds
