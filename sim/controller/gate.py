"""The gate before a real robot: what a correction asks of it, and how the run ended that made it.

Exported corrections and paths pass it, and all that `StreamedPlant` sends. Each thing that it holds
back has a name, by which it is let through: those of LIMITS, `range` and those of STATES.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from armside.arrays import Array

from ..notes import Cause
from .limits import GuidanceLimits

Beyond = Literal["size", "speed", "acceleration", "range", "diverged", "saturated", "worse", "beam"]
LIMITS: dict[str, tuple[float, float]] = {
    "size": (GuidanceLimits.correction, 5e-3),
    "speed": (np.deg2rad(50.0), 0.1),
    "acceleration": (np.deg2rad(10_000.0), 20.0),
}
"""Largest correction, its speed and its acceleration: of an axis that turns [rad, rad/s, rad/s^2],
and of one that slides [m, m/s, m/s^2]. Sizes are the defaults of KUKA's AXISCORR and POSCORR. The
others are ESTIMATES: a step of 0.2 and of 0.16 deg from one cycle of 4 ms to the next. Learned
corrections of both robots at 150 mm/s reach 2 deg/s and 130 deg/s^2."""
SHOWN = {"size": "", "speed": "/s", "acceleration": "/s^2"}
STATES: Mapping[Cause, str] = {
    Cause.SATURATION: "saturated",
    Cause.TOOL: "worse",
    Cause.BEAM: "beam",
}
"""Notes on the last run of an experiment after which its correction is held back. `diverged` is
that of an experiment."""


class GateError(ValueError):
    """A correction that is not let through to a robot."""


def exceeded(
    correction: Array,
    period: float,
    *,
    path: Array | None = None,
    limits: GuidanceLimits | None = None,
    slides: Sequence[bool] = (),
) -> dict[str, str]:
    """What a correction (N, n) [rad] exceeds, a sentence by its name; empty where nothing.

    It is a step where it does not begin at zero. period: [s]. path: r (N, n), whose sum with it the
    limits are held to. slides: axes that slide, whose correction is in [m].
    """
    found: dict[str, str] = {}
    u = np.vstack((np.zeros_like(correction[:1]), correction))
    sliding = np.array(slides or [False] * u.shape[1])
    for order, (name, (turning, along)) in enumerate(LIMITS.items()):
        most = np.where(sliding, along, turning)
        value = np.abs(np.diff(u, order, axis=0)) / period**order
        k, axis = np.unravel_index(np.argmax(value / most), value.shape)
        if not value[k, axis] <= most[axis]:
            factor, unit = (1e3, "mm") if sliding[axis] else (180.0 / np.pi, "deg")
            allowed = f"{factor * most[axis]:.6g} {unit}{SHOWN[name]}"
            got = f"got {factor * value[k, axis]:.6g}"
            found[name] = f"the correction of axis {axis + 1} must be within {allowed}, {got}"
    if path is None or limits is None:
        return found
    commanded, limits = path + correction, replace(limits, period=period)
    outside = map(limits.out_of_range, commanded)
    fast = map(limits.too_fast, commanded[1:], commanded[:-1])
    for name, each, first in (("range", outside, 0), ("speed", fast, 1)):
        if wrong := next((f"sample {k}: {said}" for k, said in enumerate(each, first) if said), ""):
            found[name] = f"{found[name]}; {wrong}" if name in found else wrong
    return found


def let_through(found: Mapping[str, str], beyond: Collection[str]) -> list[str]:
    """What is let through by its name, a line each. Raises GateError for anything else."""
    if held := [name for name in found if name not in beyond]:
        said = "; ".join(f"{name}: {found[name]}" for name in held)
        raise GateError(f"{said}. Held back from robots; beyond {' '.join(held)} lets it through")
    return [f"beyond {name}: {text}" for name, text in found.items()]


def check_names(beyond: Collection[str]) -> None:
    """Raise ValueError for a name that is none of the gate."""
    if unknown := [name for name in beyond if name not in get_args(Beyond)]:
        names = ", ".join(get_args(Beyond))
        raise ValueError(f"Unknown name {unknown[0]!r}. beyond takes {names}")
