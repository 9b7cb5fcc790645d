"""Measures of a learned cut as arrays, for claims about what is learned."""

import numpy as np

from armside.arrays import Array
from armside.sim.laser.design import Design
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.results import run
from armside.sim.laser.specification import Cut

NAMES = ("motor_inf", "motor_two", "arm_rms", "arm_maxdev")


def learned(cut: Cut, seed: int, design: Design | None = None) -> dict[str, Array]:
    """Motor norms (K + 1, 6) [rad of the motor shaft] and tool deviations (K + 1,) [m]."""
    rows = run(cut, measure=MotorAngles(design), seed=seed)["iterations"]
    return {name: np.array([row[name] for row in rows]) for name in NAMES}
