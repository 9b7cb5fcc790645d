"""A design that `armside tune` found, read from the summary.json it has written."""

import json
from pathlib import Path

from armside.sim.laser.design import Design
from armside.sim.tuning.action import VARIABLES

from .study import parameter_names


def load_design(file: Path) -> Design:
    """The best design of a search: shared by all motors, or one for each.

    Raises ValueError for a file that does not exist, is no summary of `armside tune`, or found no
    design.
    """
    try:
        best = json.loads(file.read_text(encoding="utf-8"))["best"]
        gamma, delta, cutoff = (
            (best[v.name],)
            if v.name in best
            else tuple(best[name] for name in parameter_names(v.name))
            for v in VARIABLES
        )
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{file} is no summary.json of armside tune") from error
    return Design(gamma=gamma, delta=delta, cutoff=cutoff)
