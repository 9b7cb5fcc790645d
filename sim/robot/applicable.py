"""Parameters of an individual that a design has."""

from dataclasses import replace
from typing import Any

import numpy as np

from .effects import Effect, available
from .individual import OF_STRUCTURE, Individual, structure_hinges
from .mjcf import ModelError
from .model import RobotModel

_NEEDS = {
    Effect.LOST_MOTION: ("lost motion", ("lost_motion",)),
    Effect.GEAR_ERROR: ("transmission error", ("gear_error", "gear_error_phase")),
    Effect.RIPPLE: ("torque ripple", ("ripple",)),
    Effect.LOAD_FRICTION: (
        "friction that depends on load",
        ("friction_constant", "friction_load", "static_excess"),
    ),
}
_DESIGN = Individual()


def inapplicable(design: RobotModel) -> dict[str, str]:
    """Fields of `Individual` that change nothing in a design, each with what the design lacks."""
    has, lacking = available(design), dict[str, str]()
    for effect, (what, names) in _NEEDS.items():
        if effect not in has:
            lacking |= dict.fromkeys(names, what)
    if not has & {Effect.RIPPLE, Effect.GEAR_ERROR}:
        lacking["ripple_phase"] = "torque ripple or transmission error"
    if not len(design.flex):
        lacking |= dict.fromkeys(("gear_stiffness", "gear_damping"), "flexible gears")
    if not structure_hinges(design):
        lacking |= dict.fromkeys(OF_STRUCTURE, "hinges of the structure")
    return lacking


def check_applies(design: RobotModel, individual: Individual) -> None:
    """Raise ModelError for a parameter that the design lacks, or a wrong number of its hinges."""
    for name, what in inapplicable(design).items():
        if np.any(getattr(individual, name) != getattr(_DESIGN, name)):
            raise ModelError(f"{name} does not apply to a robot without {what}: leave it out")
    individual.of(design.n_axes)
    n = len(structure_hinges(design))
    for name in OF_STRUCTURE:
        if np.ndim(value := getattr(individual, name)) and np.size(value) != n:
            allowed = f"one factor or {n}, one for each hinge of the structure"
            raise ModelError(f"{name} must be {allowed}, got {np.size(value)}")


def restricted(individual: Individual, design: RobotModel) -> Individual:
    """The individual without parameters that the design lacks."""
    nothing: dict[str, Any] = {name: getattr(_DESIGN, name) for name in inapplicable(design)}
    return replace(individual, **nothing)
