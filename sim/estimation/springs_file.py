"""Identified springs on disk: the entry `springs` of the summary of `armside identify`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..records.errors import InputError
from ..records.summary import plain
from .arm_springs import Springs

_SHAPES: Mapping[str, tuple[int, ...]] = {
    "stiffness": (6, 6),
    "damping": (6,),
    "clock_offset": (),
    "distrust": (),
    "mounting": (3,),
}
"""By key, in the order of `Springs`; `distrust` is `Springs.process_noise`."""


def springs_entry(springs: Springs) -> dict[str, Any]:
    """Springs as an entry of a summary."""
    return {"distrust" if name == "process_noise" else name: v for name, v in vars(springs).items()}


def read_springs(folder: Path, place: Mapping[str, Any]) -> Springs:
    """Springs from a folder of `armside identify`.

    place: the options that name the place, such as {"pose": "p1"}; springs are local.

    Raises:
        InputError: there are none, entries are missing or wrong, or the place is another.
    """
    file = folder / "summary.json"
    try:
        stored = json.loads(file.read_text(encoding="utf-8"))
        springs = stored["springs"]
        known_at = {name: stored["config"].get(name) for name in place}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{folder} holds no identification of armside identify") from error
    if known_at != plain(place):
        said = ", ".join(f"{name} {value}" for name, value in known_at.items() if value)
        raise InputError(f"{folder} was identified at {said}: springs act together by pose")
    return _springs(springs, file)


def _springs(stored: Any, file: Path) -> Springs:
    missing = [name for name in _SHAPES if name not in stored]
    if missing:
        raise InputError(f"{file}: springs lack {', '.join(missing)}; identify again")
    found = {}
    for name, shape in _SHAPES.items():
        try:
            value = np.array(stored[name], dtype=np.float64)
        except (ValueError, TypeError):
            value = np.array(np.nan)
        if value.shape != shape or not np.isfinite(value).all():
            raise InputError(f"{file}: springs.{name} must be numbers of shape {shape}")
        found[name] = value
    K, D, clock, noise, mounting = found.values()
    return Springs(K, D, float(clock), float(noise), mounting)
