"""MJCF of the hardware of a robot file: the same text for the same file, in a cache folder."""

import hashlib
import os
import re
import tempfile
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from armside import kinematics
from armside.kinematics import Limits

from ..robot.mjcf import mass_matrix
from .body_frames import frames
from .drive_rules import RigidArm, drives
from .hardware import Hardware, Report, StructureHinge, Taken
from .masses import masses
from .mjcf_writer import Spring, Tree, full_mjcf, rigid_mjcf


@dataclass(frozen=True)
class Built:
    """Virtual hardware of a robot."""

    text: str
    """MJCF."""
    taken: tuple[Taken, ...]
    """Numbers that the file does not give."""


def build(
    robot: kinematics.Robot,
    limits: Limits,
    hardware: Hardware,
    *,
    home: tuple[float, ...] | None = None,
    with_imu: kinematics.Robot | None = None,
) -> Built:
    """MJCF of a robot with its hardware, and the estimates in it.

    home: motor angles [rad] at which inertias are taken; the place within the limits nearest to
    zero if None. with_imu: the robot with constant links to its IMU, which is at the tool if None.
    Raises ValueError for a coupling between motors, or numbers that contradict each other.
    """
    chain, report = frames(robot), Report()
    found = masses(hardware, chain, report)
    imu = np.eye(4)
    if with_imu is not None:  # in the tool frame
        tool, own = (
            kinematics.compile(r).pose(np.zeros(robot.n_joints)) for r in (robot, with_imu)
        )
        imu = np.linalg.inv(tool) @ own
    at = np.clip(np.zeros(robot.n_joints), limits.lower, limits.upper) if home is None else home
    tree = Tree(chain, found, limits, (), (), (), imu)
    arm = RigidArm(_compiled(rigid_mjcf(tree, hardware)), np.array(at), limits)
    completed = drives(hardware, chain, limits, arm, report)
    armature = completed["gear_ratio"] ** 2 * completed["rotor_inertia"]
    gears = [Spring(*pair) for pair in zip(completed.stiffness, completed.damping, strict=True)]
    structure = _structure(tree, hardware, arm, report)
    rotor, gear = "armature: ratio squared times rotor inertia", "gear spring and damper"
    names = {one.field for one in report.taken if one.rule.startswith("ESTIMATE")}
    rotor += ", ESTIMATE" if "drives: rotor_inertia" in names else ""
    gear += ", ESTIMATE" if names & {"gears: stiffness", "gears: damping"} else ""
    tree = replace(
        tree, armature=armature, gears=gears, structure=structure, estimates=(rotor, gear)
    )
    shown = " ".join(robot.name.replace("--", "- -").split())
    comment = (
        f"  {shown}: written from its robot file by armside; do not edit, change the robot file.\n"
        "  ESTIMATE marks what the file does not give; `armside robot check` lists each with its "
        "rule."
    )
    text = full_mjcf(robot.name, comment, tree, hardware, completed)
    _compiled(text)
    return Built(text, tuple(report.taken))


def cached(name: str, text: str) -> Path:
    """File with that text in the cache folder, or in a temporary one where that is read-only."""
    from platformdirs import user_cache_path

    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    word = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower() or "robot"
    file = user_cache_path("armside", appauthor=False) / "robots" / f"{word}-{digest}.xml"
    try:
        return _written(file, text)
    except OSError:
        return _written(_temporary() / file.name, text)


def _written(file: Path, text: str) -> Path:
    if file.is_file() and file.read_text(encoding="utf-8") == text:
        return file
    file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    handle, partial = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.")
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        stream.write(text)
    os.replace(partial, file)
    return file


@lru_cache(maxsize=1)
def _temporary() -> Path:
    return Path(tempfile.mkdtemp(prefix="armside-robots-"))


def _compiled(text: str) -> mujoco.MjModel:
    try:
        return mujoco.MjSpec.from_string(text).compile()
    except ValueError as error:
        first = str(error).strip().splitlines()[0]
        raise ValueError(f"the hardware makes no model: {first}") from error


def _structure(
    tree: Tree, hardware: Hardware, arm: RigidArm, report: Report
) -> list[tuple[StructureHinge, Spring]]:
    """Hinges with their dampers, from a damping ratio where the file gives none."""
    free = [(hinge, Spring(0.0, 0.0)) for hinge in hardware.structure]
    if not free:
        return []
    mj = _compiled(rigid_mjcf(replace(tree, structure=free), hardware))
    qpos = np.zeros(mj.nq)
    for i, angle in enumerate(arm.home, 1):
        qpos[mj.joint(f"motor_{i}").qposadr[0]] = angle
    M = mass_matrix(mj, qpos)
    found, rule = [], "2 damping_ratio times the root of stiffness times inertia at home"
    for hinge in hardware.structure:
        if (damping := hinge.damping) is None:
            dof = int(mj.joint(f"struct_{hinge.name}").dofadr[0])
            own = 2.0 * hinge.damping_ratio * np.sqrt(hinge.stiffness * M[dof, dof])
            damping = float(report.take(f"structure {hinge.name}: damping", [own], rule)[0])
        found.append((hinge, Spring(hinge.stiffness, damping)))
    return found
