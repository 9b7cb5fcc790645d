"""Ranks of entries: known answers by hand."""

from itertools import product

import numpy as np
import pytest

from armside.sim.contest.ranking import DRAWS, holm, interval, permutation, standings
from armside.sim.contest.table import table


@pytest.mark.parametrize(
    ("difference", "p"),
    [
        ([1.0, 2.0, 3.0], 2 / 8),  # +++ and ---
        ([1.0, 1.0, -1.0], 1.0),  # every sum of three signs is at least 1 in size
        ([1.0, 2.0, -0.5, 4.0], 4 / 16),  # |6.5|: both whole sums of 7.5 and of 6.5
        ([0.0, 0.0], 1.0),
        ([1.0] * 10, 2 / 1024),
    ],
)
def test_exact_permutation_is_that_of_the_enumeration_by_hand(difference, p):
    zero = np.zeros(len(difference))
    assert permutation(np.array(difference), zero) == pytest.approx(p)
    assert permutation(zero, np.array(difference)) == pytest.approx(p)


def test_drawn_signs_agree_with_all_signs():
    d = np.random.default_rng(3).normal(0.4, 1.0, 14)
    signs = np.array(list(product((-1, 1), repeat=14)))
    exact = np.mean(np.abs(signs @ d) >= abs(d.sum()) - 1e-12)
    assert permutation(d, 0 * d) == pytest.approx(exact, abs=5 * np.sqrt(exact / DRAWS))


def test_holm_by_hand():
    # sorted 0.005 0.01 0.03 0.04, times 4 3 2 1: 0.02 0.03 0.06 0.04, then never falling
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])


def test_a_bootstrap_interval_holds_the_mean_in_about_95_of_100():
    rng = np.random.default_rng(0)
    ends = [interval(rng.normal(0.0, 1.0, 60)) for _ in range(400)]
    assert 0.90 < np.mean([low <= 1.0 <= high for low, high in ends]) < 0.98


def test_entries_that_do_not_differ_share_a_rank():
    rng = np.random.default_rng(1)
    task = rng.normal(0.0, 0.5, 60)
    noise = rng.normal(0.0, 0.05, (3, 60))
    left = {
        "bad": np.exp(task + 0.5),
        "good": np.exp(task - 1.0 + noise[0]),
        "as good": np.exp(task - 1.0 + noise[1]),
    }
    found = {one.name: one for one in standings(left)}
    assert {name: one.rank for name, one in found.items()} == {"good": 1, "as good": 1, "bad": 3}
    assert found["bad"].score == pytest.approx(np.exp(np.mean(task) + 0.5))
    assert found["bad"].low < found["bad"].score < found["bad"].high


def result(name, left, first=0, lost=()):
    rows = [
        {
            **{"index": first + i, "left": x, "curve": [x], "harm": x > 1.05, "runs": 1 + i},
            **{"seconds": 0.25 * i, "reason": "raised" if i in lost else ""},
        }
        for i, x in enumerate(left)
    ]
    about = {"schema": "1", "track": "joint", "round": "a", "salt_sha256": ""}
    about |= {"code": "c", "versions": {"numpy": "2"}}
    return {**about, "entry": {"name": name, "sha256": name}, "tasks": rows}


def test_a_table_ranks_on_all_tasks():
    one = result("a", [0.5, 9.0], lost=[1])
    rows, n = table([one, result("b", [4.0, 4.0])])
    assert n == 2
    assert [row["left"] for row in rows] == pytest.approx([np.sqrt(4.5), 4.0])
    assert [row["harm"] for row in rows] == [0.5, 1.0]
    assert [row["worst"] for row in rows] == [9.0, 4.0]
    assert [row["lost"] for row in rows] == [1, 0]
    assert [row["runs"] for row in rows] == [1.5, 1.5]
    assert [row["seconds"] for row in rows] == [0.125, 0.125]
    assert [row["reasons"] for row in rows] == [["raised"], []]


@pytest.mark.parametrize(
    ("results", "why"),
    [
        ([result("a", [1.0]), result("a", [1.0])], "two results"),
        ([result("a", [1.0]), result("b", [1.0], first=5)], "b cannot be ranked: .* lacks 1 of 0"),
        ([result("a", [1.0]), result("b", [1.0, 2.0])], "a cannot be ranked: .* lacks 1 of 0 to 1"),
        ([result("a", [])], "a cannot be ranked"),
        ([result("a", [1.0]), result("b", [1.0]) | {"round": "c"}], "several rounds"),
        ([result("a", [1.0]), result("b", [1.0]) | {"code": "d"}], "several codes"),
        ([result("a", [1.0]), result("b", [1.0]) | {"versions": {}}], "several versions"),
    ],
)
def test_results_that_do_not_belong_together_are_refused(results, why):
    with pytest.raises(ValueError, match=why):
        table(results)
