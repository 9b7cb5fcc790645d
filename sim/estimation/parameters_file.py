"""Identified springs on disk: the entry `springs` of the summary of `armside identify`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..records.errors import InputError
from ..records.files import check_file
from .arm_springs import Springs

_KEYS = ("stiffness", "damping", "clock_offset", "distrust", "mounting")
"""In the order of `Springs`; `distrust` is `Springs.process_noise`."""
FARTHEST = 0.6
"""Distance at which identified springs still serve [m]: 0.02 to 0.19 of the first error is left
there; 0.9 m away the innovations on them are twice what they should be."""


def springs_entry(springs: Springs) -> dict[str, Any]:
    """Springs as an entry of a summary."""
    return {"distrust" if name == "process_noise" else name: v for name, v in vars(springs).items()}


def read_springs(folder: Path, robot: str, position: Sequence[float], n_axes: int = 6) -> Springs:
    """Springs from a folder of `armside identify`.

    Payload and IMU may be others: inertia is known, and clocks are found again. position: of the
    cut, (3,) [m], base axes.

    Raises:
        InputError: there are none, entries are missing or wrong, the robot is another, or the place
            is too far away.
    """
    file = folder / "summary.json"
    try:
        stored = json.loads(check_file(file).read_text(encoding="utf-8"))
        springs, known = stored["springs"], str(stored["config"]["robot"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{folder} holds no identification of armside identify") from error
    if known != robot:
        raise InputError(f"{folder} was identified on robot {known}, not on {robot}")
    away = float(np.linalg.norm(_array(stored, "place", (3,), file) - np.asarray(position)))
    if away > FARTHEST:
        limit = f"springs act together by pose, so {1e3 * FARTHEST:g} mm at most"
        raise InputError(f"{folder} was identified {1e3 * away:.0f} mm away: {limit}")
    return _springs(springs, file, n_axes)


def _array(stored: Any, name: str, shape: tuple[int, ...], file: Path) -> Array:
    """An entry of that shape. Raises InputError for anything else."""
    try:
        value = np.array(stored[name], dtype=np.float64)
    except (ValueError, TypeError, KeyError):
        value = np.array(np.nan)
    if value.shape != shape or not np.isfinite(value).all():
        raise InputError(f"{file}: {name} must be numbers of shape {shape}")
    return value


def _springs(stored: Any, file: Path, n: int) -> Springs:
    missing = [name for name in _KEYS if name not in stored]
    if missing:
        raise InputError(f"{file}: springs lack {', '.join(missing)}; identify again")
    entries = {f"springs.{name}": stored[name] for name in _KEYS}
    shapes = zip(entries, ((n, n), (n,), (), (), (3,)), strict=True)
    K, D, clock, noise, mounting = (_array(entries, name, shape, file) for name, shape in shapes)
    return Springs(K, D, float(clock), float(noise), mounting)
