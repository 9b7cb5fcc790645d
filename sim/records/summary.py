"""`summary.json`: what was asked for, with which versions, and what came out.

Strict JSON: a value that is not finite is written as null. Floats keep every bit.
"""

import json
import math
import platform
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from enum import Enum
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from .run_folder import FORMAT

VERSIONED = ("armside", "mujoco", "numpy")


def summary(
    experiment: str, cfg: Any, common: Any, *, status: str = "done", **results: Any
) -> dict[str, Any]:
    """The summary of a run: all options, seed and versions under `config`, then `results`.

    cfg: the experiment's own options, a dataclass or a mapping. common: those of every command.
    """
    versions = {name: version(name) for name in VERSIONED} | {"python": platform.python_version()}
    config = {"experiment": experiment} | plain(cfg) | plain(common) | {"versions": versions}
    return {"format": FORMAT, "config": config, "status": status} | plain(results)


def plain(value: Any) -> Any:
    """The same value of dicts, lists, strings, numbers, booleans and None only."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, Enum):
        return plain(value.value)
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def dumps(value: Any) -> str:
    """Strict JSON of a value, indented, ending with a newline. Raises TypeError on odd types."""
    return json.dumps(plain(value), indent=2, allow_nan=False) + "\n"
