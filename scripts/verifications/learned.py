"""Measures of `armside laser` as arrays, for claims about what is learned."""

import numpy as np

from armside.arrays import Array

from ..commands.laser import LaserCfg, run

NAMES = ("motor_inf", "motor_two", "arm_rms", "arm_maxdev")


def learned(cfg: LaserCfg, seed: int) -> dict[str, Array]:
    """Motor norms (K + 1, 6) [rad of the motor shaft] and tool deviations (K + 1,) [m]."""
    rows = run(cfg, seed)["iterations"]
    return {name: np.array([row[name] for row in rows]) for name in NAMES}
