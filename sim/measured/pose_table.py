"""Measured poses of any arm as one table: CSV, Parquet, MATLAB or HDF5.

motor_angle_1 .. motor_angle_n           [rad] on the arm side of the gear
target_1_x, target_1_y, target_1_z       [m] in the frame of the instrument; empty where unseen
target_2_x, ...                          further targets fixed to the tool
tool_qw, tool_qx, tool_qy, tool_qz       orientation of the tool in that frame [optional]
"""

from pathlib import Path

import numpy as np
import pyarrow as pa

from armside.arrays import Array
from armside.kinematics.calibration import Measurements
from armside.kinematics.rotation import from_quaternion

from ..records.tables import read_table
from .pose_source import PoseSource

QUATERNION = ("tool_qw", "tool_qx", "tool_qy", "tool_qz")


def read(file: Path) -> PoseSource:
    """Poses of a table. Raises ValueError for columns that are missing."""
    table = read_table(file)
    motors = _numbered(table, "motor_angle_{}")
    targets = _numbered(table, "target_{}_x")
    if not motors or not targets:
        form = "motor_angle_1.. [rad] and target_1_x, target_1_y, target_1_z [m]"
        raise ValueError(f"{file.name} is no table of poses: it needs columns {form}")
    phi = _columns(file, table, [f"motor_angle_{i}" for i in motors])
    points = [_columns(file, table, [f"target_{i}_{a}" for a in "xyz"]) for i in targets]
    rotation = None
    if set(QUATERNION) <= set(table.column_names):
        rotation = from_quaternion(_columns(file, table, list(QUATERNION)))
    measurements = Measurements(phi=phi, points=np.stack(points, axis=1), rotation=rotation)
    return PoseSource(measurements, "table of poses")


def _numbered(table: pa.Table, form: str) -> list[int]:
    """1, 2, ... as long as there are columns of that name."""
    numbers: list[int] = []
    while form.format(len(numbers) + 1) in table.column_names:
        numbers.append(len(numbers) + 1)
    return numbers


def _columns(file: Path, table: pa.Table, names: list[str]) -> Array:
    if absent := [name for name in names if name not in table.column_names]:
        raise ValueError(f"{file.name}: columns are missing: {', '.join(absent)}")
    try:
        columns = [table[name].cast(pa.float64()).to_numpy() for name in names]
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
        raise ValueError(f"{file.name}: {error}") from error
    return np.column_stack(columns).astype(np.float64)
