"""The programmed tool motion as JSON, and back bit for bit, without planning.

Stored are the contour, its plane, the leads and the phases of the timing, as they were planned. The
samples at the log rate are evaluated from them.
"""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..motion.contour import ArcsAndLines, Circle, ClosedCurve
from ..motion.path import CuttingPath, Plane
from ..motion.timing import Timing
from ..motion.tool_motion import ToolMotion
from ..part.motion import PartMotion
from . import part_path
from .summary import plain

LEADS = ("lead_in", "lead_out", "spiral")
SPEEDS = ("programmed_speed", "reached_speed", "rest_before")


def to_json(motion: ToolMotion | PartMotion) -> dict[str, Any]:
    """Block of JSON values. Raises ValueError for a contour that is no Circle or ArcsAndLines."""
    if isinstance(motion, PartMotion):
        return part_path.to_json(motion)
    path = motion.path
    if not isinstance(path.curve, (Circle, ArcsAndLines)):
        given = type(path.curve).__name__
        raise ValueError(f"a contour of class {given} cannot be stored; Circle, ArcsAndLines can")
    block = {
        "contour": asdict(path.curve),
        "plane": asdict(path.plane),
        "timing": asdict(motion.timing),
        "n_samples": len(motion.time),
        "step": motion.time[1] - motion.time[0],
        "quaternion": motion.quaternion[0],
        "contour_time": motion.contour_time,
        "limits_hit": motion.limits_hit,
    }
    block |= {name: getattr(path, name) for name in LEADS}
    return plain(block | {name: getattr(motion, name) for name in SPEEDS})


def from_json(block: Mapping[str, Any]) -> ToolMotion | PartMotion:
    """Motion of a block written by `to_json`. Raises KeyError for another block."""
    if "legs" in block:
        return part_path.from_json(block)
    path = CuttingPath(
        curve=_curve(block["contour"]),
        plane=Plane(**{name: np.array(value) for name, value in block["plane"].items()}),
        **{name: block[name] for name in LEADS},
    )
    stored = block["timing"]
    timing = Timing(np.array(stored["start"]), np.array(stored["state"]), stored["duration"])
    first, last = block["contour_time"]
    time = np.arange(block["n_samples"], dtype=np.float64) * block["step"]
    arc_length, _, _ = timing.at(time - block["rest_before"])
    return ToolMotion(
        time=time,
        position=path.position(arc_length),
        quaternion=np.tile(block["quaternion"], (len(time), 1)),
        arc_length=arc_length,
        on_contour=(time >= first) & (time < last),
        contour_time=(first, last),
        limits_hit=tuple((name, axis, at) for name, axis, at in block["limits_hit"]),
        path=path,
        timing=timing,
        **{name: block[name] for name in SPEEDS},
    )


def _curve(block: Mapping[str, Any]) -> ClosedCurve:
    if "radius" in block:
        return Circle(block["radius"])
    elements = tuple((length, curvature) for length, curvature in block["elements"])
    return ArcsAndLines((block["start"][0], block["start"][1]), elements)
