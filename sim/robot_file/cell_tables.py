"""Cells on disk: a robot with its hardware or model, poses and programs in TOML.

The kinematics are those of a robot file (`armside.kinematics.robot_file`) or of a URDF. Beside them
stand the keys `OF_CELL`: model or tables of hardware, poses, programs, default design, all of them
in docs/robots.md with units and defaults. Before anything runs, the kinematics of a model are
compared with those of the file.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Joint
from armside.kinematics.robot_file import (
    KEYS,
    OF_CELL,
    Arm,
    arm_in,
    beside,
    links_of,
    numbers,
    refuse_unknown,
)
from armside.kinematics.rotation import to_quaternion

from ..cell import Cell, Learning, ToolPose, tool_at
from ..robot.virtual_robot import LOG_PERIOD
from .build import build, cached
from .hardware import LinkBody, Taken
from .masses import bodies_of
from .reading import TABLES, needs, read_hardware
from .reading import table as checked

_LEARNING = ("gamma", "delta", "cutoff")
_UNIT = 1e-3
"""Largest difference of a quaternion's length from 1."""
_NYQUIST = 0.5 / LOG_PERIOD
FIRST_POSE = "p1"
BEND = 0.5
"""[rad], of each axis away from the middle of its range, at which a first pose is placed: an arm
that is stretched has a singularity there. ESTIMATE."""
HELD_FROM = 6
"""Axes from which on the tool's orientation is held by default."""


def cell_of(data: Mapping[str, Any], folder: Path) -> Cell:
    """Cell of the tables of a file in a folder. Raises ValueError with the name of the field."""
    refuse_unknown("the file", data, (*KEYS, *OF_CELL))
    arm, tree = arm_in(data, folder)
    robot, limits = arm
    home = _vector("home", data["home"], robot.n_joints) if "home" in data else None
    at_home = "pose" not in data
    if home is None and at_home:
        home = bent(arm)
    if home is not None and not limits.contain(home):
        raise ValueError(f"home must be within the limits, got {list(home)}")
    with_imu = robot
    if "imu" in data:
        fixed = (replace(link, joint=Joint.FIXED) for link in links_of("imu", data["imu"]))
        with_imu = replace(robot, links=(*robot.links, *fixed), name=f"{robot.name} with IMU")
    if home and at_home:
        poses = {FIRST_POSE: tool_at(robot, home)}
    elif isinstance(tables := data["pose"], dict) and tables:
        poses = {name: _pose(f"pose {name}", table) for name, table in tables.items()}
    else:
        raise ValueError("needs at least one table [pose.NAME]")
    programs = _programs(data.get("program", {}), folder)
    orientation = data.get("orientation", "held" if robot.n_joints >= HELD_FROM else "free")
    if orientation not in ("held", "free"):
        raise ValueError(f"orientation must be one of held, free, got {orientation!r}")
    learning = _learning(data.get("learning"))
    bodies = () if tree is None else bodies_of(tree)
    xml, estimates = _hardware(arm, bodies, with_imu, home, data, folder)
    if at_home:
        position = poses[FIRST_POSE].position
        estimates += (Taken(f"pose {FIRST_POSE}: position", position, "the tool at home"),)
    if tree is not None and tree.without_speed and "speed" not in data.get("limits", {}):
        rule = f"ESTIMATE: the URDF has no speed of {', '.join(tree.without_speed)}"
        estimates += (Taken("limits: speed", limits.speed, rule),)
    return Cell(
        xml=xml,
        estimates=estimates,
        robot=robot,
        with_imu=with_imu,
        limits=limits,
        poses=poses,
        programs=programs,
        home=home,
        free_rotation=orientation == "free",
        learning=learning,
    )


def bent(arm: Arm) -> tuple[float, ...]:
    """Motor angles of a bent arm within the limits, (n,)."""
    low, high = np.array(arm.limits.lower), np.array(arm.limits.upper)
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    middle = np.where((low < 0) & (high > 0), 0.0, middle)
    signs = np.where(np.arange(len(low)) % 2 == 0, 1.0, -1.0)
    bend = np.where(arm.robot.slides, 0.0, np.minimum(BEND, 0.5 * half) * signs)
    return tuple(np.clip(middle + bend, low, high).round(4).tolist())


def _hardware(
    arm: Arm,
    bodies: tuple[LinkBody, ...],
    with_imu: kinematics.Robot,
    home: tuple[float, ...] | None,
    data: Mapping[str, Any],
    folder: Path,
) -> tuple[Path, tuple[Taken, ...]]:
    """MJCF that the file names, or that is built from it, with the estimates in that."""
    if "model" in data:
        if given := [name for name in TABLES if name in data]:
            raise ValueError(f"model has the hardware: leave out {', '.join(given)}")
        return beside(folder, "model", data["model"]), ()
    hardware = read_hardware(data, arm.robot.n_joints)
    if not hardware.bodies:
        hardware = replace(hardware, bodies=bodies)
    built = build(arm.robot, arm.limits, hardware, home=home, with_imu=with_imu)
    return cached(arm.robot.name, built.text), built.taken


def _pose(where: str, table: Any) -> ToolPose:
    table = checked(where, table, ("position", "quaternion", "rotation"))
    x, y, z = _vector(f"{where}: position", table.get("position"), 3)
    if "rotation" in table:
        if "quaternion" in table:
            raise ValueError(f"{where}: give quaternion or rotation, not both")
        a, b, c, d = to_quaternion(_rotation(f"{where}: rotation", table["rotation"])).tolist()
        return ToolPose((x, y, z), (a, b, c, d))
    q = _vector(f"{where}: quaternion", table.get("quaternion", [1, 0, 0, 0]), 4)
    length = float(np.linalg.norm(q))
    if abs(length - 1.0) > _UNIT:
        raise ValueError(f"{where}: quaternion must have length 1, got {length:.4g}")
    a, b, c, d = q if abs(length - 1.0) < 1e-12 else (value / length for value in q)
    return ToolPose((x, y, z), (a, b, c, d))


def _rotation(where: str, rows: Any) -> Array:
    """Rotation matrix (3, 3), whose columns are the tool's axes in base axes."""
    if not (isinstance(rows, list) and len(rows) == 3 and all(isinstance(r, list) for r in rows)):
        raise ValueError(f"{where} must be 3 rows of 3 numbers, got {rows!r}")
    R = np.array([_vector(where, row, 3) for row in rows])
    if np.abs(R.T @ R - np.eye(3)).max() > _UNIT:
        raise ValueError(f"{where} must have columns of length 1 at right angles, got {rows}")
    if np.linalg.det(R) < 0.0:
        raise ValueError(f"{where} must be right-handed, got a reflection: {rows}")
    return R


def _programs(table: Any, folder: Path) -> dict[str, tuple[Path, ...]]:
    if not isinstance(table, dict):
        raise ValueError(f"program must be a table of lists of files, got {table!r}")
    found = dict[str, tuple[Path, ...]]()
    for name, files in table.items():
        if not isinstance(files, list):
            raise ValueError(f"program: {name} must be a list of files, got {files!r}")
        found[name] = tuple(beside(folder, f"program: {name}", file) for file in files)
    return found


def _learning(table: Any) -> Learning | None:
    if table is None:
        return None
    table = checked("learning", table, _LEARNING)
    needs("learning", table, _LEARNING)
    gamma, delta, cutoff = (_vector(f"learning: {n}", [table[n]], 1)[0] for n in _LEARNING)
    if not gamma > 0.0:
        raise ValueError(f"learning: gamma must be > 0, got {gamma:g}")
    if not 0.0 < cutoff < _NYQUIST:
        most = f"below {_NYQUIST:g} Hz, half of the log rate"
        raise ValueError(f"learning: cutoff must be > 0 and {most}, got {cutoff:g}")
    if delta != int(delta) or delta < 0.0:
        raise ValueError(f"learning: delta must be a whole number of samples >= 0, got {delta:g}")
    return Learning(gamma=gamma, delta=int(delta), cutoff=cutoff)


def _vector(name: str, values: Any, size: int) -> tuple[float, ...]:
    found = numbers(name, values)
    if len(found) != size:
        raise ValueError(f"{name} must have {size} numbers, got {len(found)}")
    return tuple(found)
