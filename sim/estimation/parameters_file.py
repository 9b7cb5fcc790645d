"""Identified parameters on disk: the entry `springs` of the summary of `armside identify`."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from armside.arrays import Array

from ..records.files import InputError, check_file
from .elasticity import ArmParameters, Elasticity

_OF_SPRINGS = ("stiffness", "damping", "softening", "lost_motion")
"""Entries with a number for each spring, of gears and structure."""
_KEYS = (*_OF_SPRINGS, "gears", "clock_offset", "process_noise", "mounting")


def springs_entry(known: ArmParameters) -> dict[str, Any]:
    """Parameters as an entry of a summary."""
    springs = {name: getattr(known.springs, name) for name in _OF_SPRINGS}
    unit = {name: getattr(known, name) for name in ("clock_offset", "process_noise", "mounting")}
    return {**springs, "gears": known.springs.axes, **unit}


def read_parameters(folder: Path, robot: str, n_axes: int = 6) -> ArmParameters:
    """Parameters from a folder of `armside identify`.

    Place, payload and IMU may be others: springs are the robot's, inertia is known, and clocks are
    found again.

    Raises InputError: there are none, entries are missing or wrong, or the robot is another.
    """
    file = folder / "summary.json"
    try:
        stored = json.loads(check_file(file).read_text(encoding="utf-8"))
        springs, known = stored["springs"], str(stored["config"]["robot"])
        missing = [name for name in _KEYS if name not in springs]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{folder} holds no identification of armside identify") from error
    if known != robot:
        raise InputError(f"{folder} was identified on robot {known}, not on {robot}")
    if missing:
        raise InputError(f"{file}: springs lack {', '.join(missing)}; identify again")
    return _parameters(springs, file, n_axes)


def _parameters(stored: dict[str, Any], file: Path, n_axes: int) -> ArmParameters:
    n = len(stored["stiffness"]) if isinstance(stored["stiffness"], list) else 0
    K, D, soft, lost = (_array(stored, name, (n,), file) for name in _OF_SPRINGS)
    axes = _array(stored, "gears", (n_axes,), file)
    whole = np.isin(axes, np.arange(n)).all() and (np.diff(np.sort(axes)) > 0.0).all()
    if not (whole and (K > 0.0).all() and (D >= 0.0).all()):
        raise InputError(f"{file}: springs must be stiffer than 0, with one for each gear")
    springs = Elasticity(K, D, axes.astype(int), soft, lost)
    clock, noise = (float(_array(stored, name, (), file)) for name in _KEYS[5:7])
    if not noise > 0.0:
        raise InputError(f"{file}: springs.process_noise must be > 0, got {noise:g}")
    return ArmParameters(springs, clock, noise, _array(stored, "mounting", (3,), file))


def _array(stored: dict[str, Any], name: str, shape: tuple[int, ...], file: Path) -> Array:
    """An entry of that shape. Raises InputError for anything else."""
    try:
        value = np.array(stored[name], dtype=np.float64)
    except (ValueError, TypeError):
        value = np.array(np.nan)
    if value.shape != shape or not np.isfinite(value).all():
        raise InputError(f"{file}: springs.{name} must be numbers of shape {shape}")
    return value
