"""The table of a track: score with interval, rank, harm rate, worst, runs and seconds."""

from collections import Counter
from typing import Any

import numpy as np

from .judge import Row, gaps, identity
from .ranking import standings


def table(results: list[Row]) -> tuple[list[dict[str, Any]], int]:
    """Rows by rank, and the number of tasks, which all results have.

    Raises ValueError for results of several tracks, rounds, codes or versions, of one entry twice,
    of other numbers of tasks, or that lack one.
    """
    for at, what in enumerate(("schemas", "tracks", "rounds", "salts", "codes", "versions")):
        if len(found := {identity(r)[at] for r in results}) > 1:
            raise ValueError(f"results of several {what} cannot be ranked together: {found}")
    names = [r["entry"]["name"] for r in results]
    if twice := [name for name, n in Counter(names).items() if n > 1]:
        raise ValueError(f"there are two results of the entry {twice[0]}")
    count = max(len(r["tasks"]) for r in results)
    for r in results:
        if lacking := gaps(r, count):
            raise ValueError(f"the result of {r['entry']['name']} cannot be ranked: {lacking}")
    tasks = {r["entry"]["name"]: r["tasks"] for r in results}
    left = {name: np.array([row["left"] for row in of]) for name, of in tasks.items()}
    ranked = list[dict[str, Any]]()
    for one in standings(left):
        of = tasks[one.name]
        why = Counter(row["reason"] for row in of if row["reason"])
        ranked.append(
            {
                **{"entry": one.name, "rank": one.rank, "left": one.score},
                **{"low": one.low, "high": one.high},
                "harm": float(np.mean([row["harm"] for row in of])),
                "worst": float(left[one.name].max()),
                "lost": sum(why.values()),
                "runs": float(np.mean([row["runs"] for row in of])),
                "seconds": float(np.mean([row["seconds"] for row in of])),
                "reasons": [reason for reason, _ in why.most_common(3)],
            }
        )
    return ranked, count
