"""The programmed tool motion as JSON, and back bit for bit, without planning.

Stored are the contour, its plane, the leads and the phases of the timing, as they were planned, and
of a part those of each leg. The samples at the log rate are evaluated from them.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from armside.arrays import Array

from ..motion.contour import ArcsAndLines, Circle, ClosedCurve
from ..motion.path import CuttingPath, Plane
from ..motion.timing import Timing
from ..motion.tool_motion import ToolMotion
from ..part.arcs import Chain
from ..part.curve import Kind
from ..part.motion import CutLeg, Leg, PartMotion
from .summary import plain

LEADS = ("lead_in", "lead_out", "spiral")
OF_A_PART = ("middle", "tool_quaternion", "n_samples", "step", "rest_before", "limits_hit")
OF_A_CUT = ("name", "kind", "lead", "asked_speed")
SPEEDS = ("programmed_speed", "reached_speed", "rest_before")


def to_json(motion: ToolMotion | PartMotion) -> dict[str, Any]:
    """Block of JSON values. Raises ValueError for a contour that is no Circle or ArcsAndLines."""
    if isinstance(motion, PartMotion):
        block: dict[str, Any] = {name: getattr(motion, name) for name in OF_A_PART}
        return plain(block | {"plane": motion.plane, "legs": list(map(_of_leg, motion.legs))})
    path = motion.path
    if not isinstance(path.curve, (Circle, ArcsAndLines)):
        given = type(path.curve).__name__
        raise ValueError(f"a contour of class {given} cannot be stored; Circle, ArcsAndLines can")
    block = {
        "contour": path.curve,
        "plane": path.plane,
        "timing": motion.timing,
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
        return _part_motion(block)
    path = CuttingPath(
        curve=_curve(block["contour"]),
        plane=Plane(**_arrays(block["plane"])),
        **{name: block[name] for name in LEADS},
    )
    timing = _timing(block["timing"])
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


def _of_leg(leg: Leg) -> dict[str, Any]:
    names = ("path", "timing", "start") + OF_A_CUT * isinstance(leg, CutLeg)
    return {name: getattr(leg, name) for name in names}


def _part_motion(block: Mapping[str, Any]) -> PartMotion:
    scalars = {name: block[name] for name in OF_A_PART}
    for name in ("middle", "tool_quaternion"):
        scalars[name] = tuple(scalars[name])
    scalars["limits_hit"] = tuple((a, b, c) for a, b, c in scalars["limits_hit"])
    plane = Plane(**_arrays(block["plane"]))
    return PartMotion(legs=tuple(_leg(leg) for leg in block["legs"]), plane=plane, **scalars)


def _leg(block: Mapping[str, Any]) -> Leg:
    path, timing = Chain(**_arrays(block["path"])), _timing(block["timing"])
    if "kind" not in block:
        return Leg(path=path, timing=timing, start=block["start"])
    own: dict[str, Any] = {name: block[name] for name in OF_A_CUT}
    own["kind"] = Kind(own["kind"])
    return CutLeg(path=path, timing=timing, start=block["start"], **own)


def _arrays(block: Mapping[str, Any]) -> dict[str, Array]:
    return {name: np.array(value) for name, value in block.items()}


def _timing(block: Mapping[str, Any]) -> Timing:
    return Timing(np.array(block["start"]), np.array(block["state"]), block["duration"])
