"""The programmed tool motion as JSON, and back bit for bit, without planning.

Stored are the contour, its plane, the leads and the phases of the timing, as they were planned. The
samples at the log rate are evaluated from them.
"""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..cut.contour import ArcsAndLines, ClosedCurve
from ..cut.path import Circle, CuttingPath, Plane
from ..cut.timing import Timing
from ..cut.tool_motion import ToolMotion
from .summary import plain

CURVES: Mapping[str, type[Circle] | type[ArcsAndLines]] = {
    "circle": Circle,
    "arcs_and_lines": ArcsAndLines,
}


def to_json(motion: ToolMotion) -> dict[str, Any]:
    """Block of JSON values. Raises ValueError for a contour of another class than those here."""
    path, timing = motion.path, motion.timing
    return plain(
        {
            "contour": _curve_to_json(path.curve),
            "plane": {"origin": path.plane.origin, "axes": path.plane.axes},
            "lead_in": path.lead_in,
            "lead_out": path.lead_out,
            "spiral": path.spiral,
            "timing": {
                "start": timing.start,
                "state": timing.state,
                "duration": timing.duration,
            },
            "rest_before": motion.rest_before,
            "n_samples": len(motion.time),
            "step": motion.time[1] - motion.time[0],
            "quaternion": motion.quaternion[0],
            "contour_time": motion.contour_time,
            "programmed_speed": motion.programmed_speed,
            "reached_speed": motion.reached_speed,
            "limits_hit": motion.limits_hit,
        }
    )


def from_json(block: Mapping[str, Any]) -> ToolMotion:
    """Tool motion of a block written by `to_json`. Raises KeyError for another block."""
    path = CuttingPath(
        curve=_curve_from_json(block["contour"]),
        plane=Plane(np.array(block["plane"]["origin"]), np.array(block["plane"]["axes"])),
        lead_in=block["lead_in"],
        lead_out=block["lead_out"],
        spiral=block["spiral"],
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
        programmed_speed=block["programmed_speed"],
        reached_speed=block["reached_speed"],
        limits_hit=tuple((name, axis, at) for name, axis, at in block["limits_hit"]),
        path=path,
        timing=timing,
        rest_before=block["rest_before"],
    )


def _curve_to_json(curve: ClosedCurve) -> dict[str, Any]:
    for kind, of in CURVES.items():
        if isinstance(curve, of):
            return {"kind": kind, **asdict(curve)}
    known = ", ".join(of.__name__ for of in CURVES.values())
    raise ValueError(f"a contour of class {type(curve).__name__} cannot be stored; {known} can")


def _curve_from_json(block: Mapping[str, Any]) -> ClosedCurve:
    if block["kind"] == "circle":
        return Circle(block["radius"])
    elements = tuple((length, curvature) for length, curvature in block["elements"])
    return ArcsAndLines((block["start"][0], block["start"][1]), elements)
