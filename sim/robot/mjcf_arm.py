"""MJCF file of any arm as a Denavit-Hartenberg robot with limits and masses."""

from pathlib import Path

import mujoco
import numpy as np

from armside.kinematics.urdf import UrdfArm
from armside.kinematics.urdf.reader import arm_of

from .mjcf import model_name
from .mjcf_document import joint_name, mjcf_document

TOOL = "tool0"
"""Site that is the tip by default."""


def read_mjcf(file: Path, base: str | None = None, tip: str | None = None) -> UrdfArm:
    """The chain from a base body to a tip, a body or a site, as a robot of the base's axes.

    base: the world by default. tip: the site `tool0` where there is one, else the only end.
    Springs (flex_*, struct_*) are held at rest. A file has no greatest speeds: they are pi rad/s.

    Raises:
        ValueError: the file does not compile, or its chain is no serial arm; has file and element.
        OSError: the file cannot be read.
    """
    if not file.is_file():
        raise ValueError(f"there is no file {file}")
    try:
        mj = mujoco.MjSpec.from_file(str(file)).compile()
        document = mjcf_document(mj, _printable(model_name(mj)))
        if tip is None and TOOL in document.links:
            tip = TOOL
        arm = arm_of(document, base, tip)
        _refuse_loops(mj, arm)
    except (ValueError, TypeError, RecursionError) as error:
        first_line = str(error).strip().splitlines()[0]
        raise ValueError(f"{file.name}: {first_line}") from error
    return arm


def _printable(name: str) -> str:
    return name[:80] if name and name.isprintable() else "robot"


def _refuse_loops(mj: mujoco.MjModel, arm: UrdfArm) -> None:
    """Raise ValueError for a joint of the chain that an equality takes part in closing."""
    for i in range(mj.neq):
        if not mj.eq_active0[i]:
            continue
        for joint in np.flatnonzero(_closing(mj, i)):
            name = joint_name(mj, int(joint))
            if name in arm.joints:
                equality = mj.equality(i).name or f"equality {i}"
                raise ValueError(
                    f"joint {name!r} is part of a closed chain ({equality}); "
                    "joints must be independent"
                )


def _closing(mj: mujoco.MjModel, equality: int) -> np.ndarray:
    """(njnt,) bool: joints between the two bodies that an equality connects or welds."""
    kind = mujoco.mjtEq(int(mj.eq_type[equality]))
    ends = int(mj.eq_obj1id[equality]), int(mj.eq_obj2id[equality])
    if kind not in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        return np.zeros(mj.njnt, dtype=bool)
    if mj.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
        ends = int(mj.site_bodyid[ends[0]]), int(mj.site_bodyid[ends[1]])
    one, other = (_moving(mj, body) for body in ends)
    return one ^ other


def _moving(mj: mujoco.MjModel, body: int) -> np.ndarray:
    """(njnt,) bool: joints that move a body."""
    found = np.zeros(mj.njnt, dtype=bool)
    while body > 0:
        first = int(mj.body_jntadr[body])
        found[first : first + int(mj.body_jntnum[body])] = True
        body = int(mj.body_parentid[body])
    return found
