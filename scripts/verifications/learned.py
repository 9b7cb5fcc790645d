"""Measures of a learned cut as arrays, for claims about what is learned."""

from collections.abc import Sequence

import numpy as np

from armside.arrays import Array
from armside.sim.laser.design import Design
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import run
from armside.sim.laser.specification import Cut
from armside.sim.notes import Note

NAMES = ("motor_inf", "motor_two", "arm_rms", "arm_maxdev")


class Learned(dict[str, Array]):
    """Motor norms (K + 1, 6) [rad of the motor shaft] and tool deviations (K + 1,) [m]."""

    notes: Sequence[Note] = ()
    """Limits that changed the run."""


def learned(cut: Cut, seed: int, design: Design | None = None) -> Learned:
    """Measures of a cut that is learned from its motors."""
    found = run(cut, measure=MotorAngles(design), seed=seed)
    rows = found["iterations"]
    measures = Learned({name: np.array([row[name] for row in rows]) for name in NAMES})
    measures.notes = found["notes"]
    return measures
