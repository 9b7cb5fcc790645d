"""The table of a track: score with interval, rank, harm rate, worst, runs and seconds."""

from collections import Counter
from typing import Any

import numpy as np

from .judge import Row
from .ranking import standings


def table(results: list[Row]) -> tuple[list[dict[str, Any]], int]:
    """Rows by rank, on the tasks that all results have, and the number of these.

    Raises ValueError for results of several tracks or rounds, of one entry twice, or without common
    tasks.
    """
    if len({(r["track"], r["round"], r["salt_sha256"]) for r in results}) > 1:
        raise ValueError("results of several tracks or rounds cannot be ranked together")
    names = [r["entry"]["name"] for r in results]
    if twice := [name for name, n in Counter(names).items() if n > 1]:
        raise ValueError(f"there are two results of the entry {twice[0]}")
    rows = {r["entry"]["name"]: {row["index"]: row for row in r["tasks"]} for r in results}
    common = sorted(set.intersection(*(set(of) for of in rows.values())))
    if not common:
        raise ValueError("the results have no task in common")
    tasks = {name: [of[i] for i in common] for name, of in rows.items()}
    left = {name: np.array([row["left"] for row in of]) for name, of in tasks.items()}
    found = list[dict[str, Any]]()
    for one in standings(left):
        of = tasks[one.name]
        why = Counter(row["reason"] for row in of if row["reason"])
        found.append(
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
    return found, len(common)
