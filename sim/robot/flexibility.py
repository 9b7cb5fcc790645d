"""The same robot with other flexibilities, edited from its one MJCF file: rigid, gears only,
full."""

from enum import Enum
from pathlib import Path

import mujoco
import numpy as np


class Flexibility(Enum):
    """What of a robot gives way. Each form contains the one before."""

    RIGID = "rigid"
    GEARS = "gears"
    FULL = "full"


_REMOVED = {
    Flexibility.RIGID: ("flex_", "struct_"),
    Flexibility.GEARS: ("struct_",),
    Flexibility.FULL: (),
}
# Ball ends of a linkage only follow a bending structure; in a plane mechanism they are loose.
_LOOSE_WITHOUT_STRUCTURE = ("link_rod_x",)


def variant(
    source: Path | str,
    flexibility: Flexibility = Flexibility.FULL,
    *,
    gear_stiffness: float = 1.0,
    structure_stiffness: float = 1.0,
) -> mujoco.MjModel:
    """Compile a robot with some of its springs taken out or scaled.

    The time step stays the file's; shorten it where the highest mode [Hz] times the step [s]
    passes 0.3, beyond which an explicit integrator loses it.

    Args:
        source: MJCF file.
        gear_stiffness: factor on the springs of flex_1..6. Damping follows with its square root, so
            that the damping ratio of a spring under a given inertia stays.
        structure_stiffness: the same for struct_*.

    Raises ValueError for a factor that is not positive.
    """
    for name, factor in (("gear", gear_stiffness), ("structure", structure_stiffness)):
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"{name} stiffness factor must be > 0, got {factor}")
    spec = mujoco.MjSpec.from_file(str(source))
    without(spec, flexibility)
    mj = spec.compile()
    _scale(mj, "flex_", gear_stiffness)
    _scale(mj, "struct_", structure_stiffness)
    return mj


def without(spec: mujoco.MjSpec, flexibility: Flexibility) -> None:
    """Take the springs out of a specification that this flexibility does not have."""
    prefixes = _REMOVED[flexibility]
    for joint in list(spec.joints):
        stiffens = joint.name.startswith(prefixes) if prefixes else False
        if stiffens or (prefixes and joint.name in _LOOSE_WITHOUT_STRUCTURE):
            spec.delete(joint)


def _scale(mj: mujoco.MjModel, prefix: str, factor: float) -> None:
    for i in range(mj.njnt):
        if mj.joint(i).name.startswith(prefix):
            mj.jnt_stiffness[i] *= factor
            mj.dof_damping[mj.jnt_dofadr[i]] *= np.sqrt(factor)
