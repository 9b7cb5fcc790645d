"""The programmed motion of a part as JSON, and back bit for bit, without planning."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..motion.path import Plane
from ..motion.timing import Timing
from ..part.chain import Chain
from ..part.curve import Kind
from ..part.motion import CutLeg, Leg, PartMotion
from .summary import plain

SCALARS = ("middle", "tool_quaternion", "n_samples", "step", "rest_before", "limits_hit")


def to_json(motion: PartMotion) -> dict[str, Any]:
    """Block of JSON values."""
    block: dict[str, Any] = {name: getattr(motion, name) for name in SCALARS}
    plane = {"origin": motion.plane.origin, "axes": motion.plane.axes}
    return plain(block | {"plane": plane, "legs": [_of_leg(leg) for leg in motion.legs]})


def _of_leg(leg: Leg) -> dict[str, Any]:
    timing = leg.timing
    block: dict[str, Any] = {
        "path": {"points": leg.path.points, "bulge": leg.path.bulge},
        "timing": {"start": timing.start, "state": timing.state, "duration": timing.duration},
        "start": leg.start,
    }
    if isinstance(leg, CutLeg):
        block |= {"name": leg.name, "kind": leg.kind}
        block |= {"lead": leg.lead, "asked_speed": leg.asked_speed}
    return block


def from_json(block: Mapping[str, Any]) -> PartMotion:
    """Motion of a block written by `to_json`. Raises KeyError for another block."""
    scalars = {name: block[name] for name in SCALARS}
    for name in ("middle", "tool_quaternion"):
        scalars[name] = tuple(scalars[name])
    scalars["limits_hit"] = tuple((a, b, c) for a, b, c in scalars["limits_hit"])
    plane = Plane(**{name: np.array(value) for name, value in block["plane"].items()})
    return PartMotion(legs=tuple(_leg(leg) for leg in block["legs"]), plane=plane, **scalars)


def _leg(block: Mapping[str, Any]) -> Leg:
    timing = block["timing"]
    common: dict[str, Any] = {
        "path": Chain(**{name: np.array(value) for name, value in block["path"].items()}),
        "timing": Timing(np.array(timing["start"]), np.array(timing["state"]), timing["duration"]),
        "start": block["start"],
    }
    if "kind" not in block:
        return Leg(**common)
    own = {name: block[name] for name in ("name", "lead", "asked_speed")}
    return CutLeg(kind=Kind(block["kind"]), **common, **own)
