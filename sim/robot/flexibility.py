"""Variants of a robot with other flexibility: rigid, gears only, full, or with scaled stiffness."""

from enum import Enum
from pathlib import Path

import mujoco
import numpy as np

from .individual import joints, stiffen


class Flexibility(Enum):
    """Flexible parts of a robot; each form contains the one before."""

    RIGID = "rigid"
    GEARS = "gears"
    FULL = "full"


# The ball end of a linkage (link_rod_x) only follows the deflection of the structure.
_REMOVED = {
    Flexibility.RIGID: ("flex_", "struct_", "link_rod_x"),
    Flexibility.GEARS: ("struct_", "link_rod_x"),
    Flexibility.FULL: (),
}


def variant(
    source: Path | str,
    flexibility: Flexibility = Flexibility.FULL,
    *,
    gear_stiffness: float = 1.0,
    structure_stiffness: float = 1.0,
) -> mujoco.MjModel:
    """Compiled model of a robot's MJCF without some springs, or with scaled ones; see `stiffen`.

    The time step stays that of the file; shorten it where the highest mode [Hz] times the step [s]
    passes 0.3. Raises ValueError for a factor that is not positive.
    """
    for name, factor in (("gear", gear_stiffness), ("structure", structure_stiffness)):
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"{name} stiffness factor must be > 0, got {factor}")
    spec = mujoco.MjSpec.from_file(str(source))
    without(spec, flexibility)
    mj = spec.compile()
    stiffen(mj, joints(mj, "flex_"), gear_stiffness)
    stiffen(mj, joints(mj, "struct_"), structure_stiffness)
    return mj


def without(spec: mujoco.MjSpec, flexibility: Flexibility) -> None:
    """Remove the springs from a parsed file that this flexibility does not have."""
    for joint in list(spec.joints):
        if joint.name.startswith(_REMOVED[flexibility]):
            spec.delete(joint)
