"""Columns of a correction, of the commanded joint path, and of the commanded tool path."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from armside import kinematics
from armside.arrays import Array
from armside.kinematics import Joint
from armside.kinematics.rotation import to_quaternion

from ..cell import Cell
from .kept import KeptCorrection, commanded
from .resampling import resampled

Form = Literal["joint-correction", "joint-path", "tool-path"]
TOOL = {"x": "m", "y": "m", "z": "m"} | dict.fromkeys(("qw", "qx", "qy", "qz"), "1")


def joint_values(kept: KeptCorrection, form: Form, rate: float) -> Array:
    """(M, n) at a rate [Hz]: u, or r + u from which the other two forms are made."""
    values = kept.correction if form == "joint-correction" else commanded(kept)
    return resampled(values, kept.sample_time, rate)


Columns = dict[str, tuple[str, Array]]
"""Unit and values by name."""


def joint_columns(joints: Array, form: Form, units: Sequence[str]) -> Columns:
    """A column for each axis."""
    name = "correction" if form == "joint-correction" else "joint"
    each = zip(units, joints.T, strict=True)
    return {f"{name}_{i}": found for i, found in enumerate(each, start=1)}


def tool_columns(joints: Array, cell: Cell) -> Columns:
    """Position and unit quaternion of TCP0 in base axes, by the nominal kinematics at the angles.

    Raises ValueError for another number of axes.
    """
    if (n := len(cell.limits.lower)) != joints.shape[1]:
        raise ValueError(f"the robot has {n} axes and the correction {joints.shape[1]}")
    T_base_tool = kinematics.compile(cell.robot).pose(np.ascontiguousarray(joints))
    quaternion = _continuous(to_quaternion(T_base_tool[:, :3, :3]))
    values = np.column_stack((T_base_tool[:, :3, 3], quaternion))
    names = zip(TOOL.items(), values.T, strict=True)
    return {f"tool_{name}": (unit, column) for (name, unit), column in names}


def units_of(cell: Cell | None, n_axes: int, angle: str) -> list[str]:
    """Unit of each axis: that of angles, or m of a sliding one."""
    joints = [] if cell is None else [link.joint for link in cell.robot.links]
    moving = [joint for joint in joints if joint is not Joint.FIXED]
    return ["m" if joint is Joint.PRISMATIC else angle for joint in moving] or [angle] * n_axes


def table(found: Columns, rate: float, about: Mapping[str, Any]) -> pa.Table:
    """Columns with `time` [s] before them, and JSON texts of what they are as metadata."""
    count = len(next(iter(found.values()))[1])
    timed = {"time": ("s", np.arange(count) / rate), **found}
    fields = [pa.field(name, pa.float64(), metadata={"unit": u}) for name, (u, _) in timed.items()]
    schema = pa.schema(fields, metadata={f"armside.{key}": text for key, text in about.items()})
    return pa.Table.from_arrays([pa.array(v) for _, v in timed.values()], schema=schema)


def _continuous(quaternion: Array) -> Array:
    """The same rotations (M, 4) without jumps of sign."""
    sign = np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return quaternion * np.concatenate(([1.0], np.cumprod(sign)))[:, np.newaxis]
