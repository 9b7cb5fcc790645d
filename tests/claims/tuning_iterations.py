"""Error after each iteration, over episodes that do not diverge; designs beyond their budget."""

from collections.abc import Iterator

import numpy as np

from armside.arrays import Array
from armside.sim.tuning.rules import Rules

from . import _episodes
from ._engine import Check, Claim, Row, Rows, Tally, all_hold, at_once
from ._episodes import BY_POLICY, BY_SEARCH, BY_THESIS

TWICE = 10  # iterations, twice the budget that was searched and trained with


def run(seeds: tuple[int, ...], tally: Tally) -> Iterator[Row]:
    long, budget = Rules(iterations=TWICE, sealed=True), Rules(sealed=True)
    rules = {BY_THESIS: long, BY_SEARCH: long, BY_POLICY: budget}
    yield from _episodes.episodes(seeds, rules, tally)


def means(rows: Rows) -> dict[str, Array]:
    """Geometric mean of the RMS over that before learning, after each iteration."""
    return {
        name: np.exp(np.mean([np.log(r["rms"][1:] / r["rms"][0]) for r in _ended(own)], axis=0))
        for name, own in rows.by("baseline").items()
    }


def _ended(rows: Rows) -> list[Row]:
    return [row for row in rows if not row["diverged"]]


def shown(rows: Rows) -> Iterator[Row]:
    chosen = [row["gamma"] for row in _ended(rows.by("baseline")[BY_POLICY])]
    listed = means(rows) | {"gain γ of the learned policy, mean": np.mean(chosen, axis=0)}
    for name, values in listed.items():
        padded = [*values.tolist(), *[np.nan] * (TWICE - len(values))]
        yield {"": name} | {f"k = {k}": value for k, value in enumerate(padded, 1)}


def checks(rows: Rows) -> Iterator[Check]:
    search = means(rows)[BY_SEARCH]
    more = "the searched design is made for its budget: after ten iterations it leaves more"
    yield all_hold(more, search[-1] > search[4])


CLAIM = Claim(
    title="RMS of the tool over that before learning, geometric mean, {n} episodes",
    seeds=100,
    cases=at_once,
    run=run,
    checks=checks,
    shown=shown,
    processes=1,
)
