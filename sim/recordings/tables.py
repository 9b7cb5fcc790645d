"""Recordings of any arm as tables: CSV, Parquet, MATLAB or HDF5. Missing values are empty.

Poses are one table:

motor_angle_1 .. motor_angle_n           [rad] on the arm side of the gear
target_1_x, target_1_y, target_1_z       [m] in the frame of the instrument; empty where unseen
target_2_x, ...                          further targets fixed to the tool
tool_qw, tool_qx, tool_qy, tool_qz       orientation of the tool in that frame [optional]

A motion is a folder with a table for each instrument, by its own clock and at its own rate; stamps
need not be even:

encoders.*   time [s], motor_angle_1 .. motor_angle_n [rad] on the arm side of the gear
imu.*        time, acceleration_x, _y, _z [m/s^2], angular_velocity_x, _y, _z [rad/s]   [optional]
tracker.*    time, target_x, target_y, target_z [m], a point fixed to the tool          [optional]
"""

from pathlib import Path

import pyarrow as pa

from armside.arrays import Array
from armside.kinematics.calibration import Measurements
from armside.kinematics.rotation import from_quaternion

from ..records.files import reading
from ..records.tables import READERS, float_columns, numbered, read_table, table_of, write_table
from .recorded_motion import MotionRecording, PoseRecording, Stream, repaired

QUATERNION = ("tool_qw", "tool_qx", "tool_qy", "tool_qz")
COLUMNS = {
    "imu": tuple(f"{n}_{a}" for n in ("acceleration", "angular_velocity") for a in "xyz"),
    "tracker": tuple(f"target_{a}" for a in "xyz"),
}
UNITS = {"motor_angle": "rad", "acceleration": "m/s²", "angular_velocity": "rad/s"}
"""Of columns by the start of their names; else metres."""


def read_pose_table(file: Path) -> PoseRecording:
    """Poses of a table. Raises ValueError for columns that are missing."""
    table = read_table(file)
    motors, targets = numbered(table, "motor_angle_{}"), numbered(table, "target_{}_x")
    if not motors or not targets:
        form = "motor_angle_1.. [rad] and target_1_x, target_1_y, target_1_z [m]"
        raise ValueError(f"{file.name} is no table of poses: it needs columns {form}")
    if not table.num_rows:
        raise ValueError(f"{file.name} has no rows")
    phi = _columns(file, table, motors)
    names = [f"target_{i + 1}_{a}" for i in range(len(targets)) for a in "xyz"]
    points = _columns(file, table, names).reshape(len(phi), -1, 3)
    rotation = None
    if set(QUATERNION) <= set(table.column_names):
        rotation = from_quaternion(_columns(file, table, QUATERNION))
    with reading(file):
        measurements = Measurements(phi=phi, points=points, rotation=rotation)
    return PoseRecording(measurements, "table of poses")


def read_motion_tables(folder: Path) -> MotionRecording:
    """Recording of a folder. Raises ValueError for columns that are missing or damaged."""
    streams: dict[str, Stream] = {}
    notes: tuple[str, ...] = ()
    for name in ("encoders", *COLUMNS):
        if (file := instrument_table(folder, name)) is None:
            continue
        table = read_table(file)
        columns = COLUMNS.get(name) or numbered(table, "motor_angle_{}") or ["motor_angle_1"]
        values = _columns(file, table, ["time", *columns])
        streams[name], more = repaired(name, values[:, 0], values[:, 1:])
        notes += more
    return MotionRecording(name=folder.name, form="folder of tables", notes=notes, **streams)


def write_motion_tables(folder: Path, recording: MotionRecording, kind: str) -> None:
    """Write a recording's tables into a folder, in files of a kind such as csv."""
    n = recording.encoders.values.shape[1]
    motors = tuple(f"motor_angle_{i}" for i in range(1, n + 1))
    for name, columns in {**COLUMNS, "encoders": motors}.items():
        stream: Stream | None = getattr(recording, name)
        if stream is not None:
            units = [next((u for k, u in UNITS.items() if c.startswith(k)), "m") for c in columns]
            values = dict(zip(columns, zip(units, stream.values.T, strict=True), strict=True))
            table = table_of({"time": ("s", stream.time), **values})
            write_table(folder / f"{name}.{kind}", table)


def instrument_table(folder: Path, name: str = "encoders") -> Path | None:
    """File of the table of an instrument, if there is one."""
    found = (folder / f"{name}{suffix}" for suffix in READERS)
    return next((file for file in found if file.is_file()), None)


def _columns(file: Path, table: pa.Table, names: list[str] | tuple[str, ...]) -> Array:
    """(N, m). Raises ValueError for columns that are missing, or hold no numbers."""
    if absent := [name for name in names if name not in table.column_names]:
        raise ValueError(f"{file.name}: columns are missing: {', '.join(absent)}")
    try:
        return float_columns(table, names)
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
        raise ValueError(f"{file.name}: {error}") from error
