"""The start of a training: the design that `armside tune` found, and the number of steps."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from armside.sim.laser.design import Design
from armside.sim.tuning.action import SIX, VARIABLES, Motors, action_of

from .study import parameter_names


def load_design(file: Path) -> Design:
    """The best design of a search: shared by all motors, or one for each.

    Raises ValueError for a file that does not exist, is no summary of `armside tune`, or found no
    design.
    """
    try:
        best = json.loads(file.read_text(encoding="utf-8"))["best"]
        names = {
            v.name: [v.name] if v.name in best else _of_motors(best, v.name) for v in VARIABLES
        }
        values = {name: tuple(best[i] for i in of) for name, of in names.items()}
    except FileNotFoundError:
        raise ValueError(f"{file} does not exist") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{file} is no summary.json of armside tune") from error
    return Design(**values)


def _of_motors(best: Mapping[str, Any], variable: str) -> list[str]:
    """Names of a variable's values, one for each motor."""
    n_axes = sum(name.startswith(f"{variable}_") for name in best)
    return parameter_names(variable, max(n_axes, 1))


def first_action(file: Path | None, motors: Motors, n_axes: int = SIX) -> np.ndarray:
    """Action of the design in a file, (3,) or (3 n,); without one, of the middle of the ranges.

    Raises ValueError as `load_design`, and for a design out of the ranges.
    """
    if file is None:
        return np.zeros(len(VARIABLES) * motors.count(n_axes), np.float32)
    return action_of(load_design(file), motors, n_axes)


def whole_batches(steps: int, batch: int) -> int:
    """Steps rounded up to whole batches: the network is updated after each."""
    return -(-steps // batch) * batch
