"""Recording of any arm as a folder of tables: CSV, Parquet, MATLAB or HDF5, one an instrument.

encoders.*   time [s], motor_angle_1 .. motor_angle_n [rad] on the arm side of the gear
imu.*        time, acceleration_x, _y, _z [m/s^2], angular_velocity_x, _y, _z [rad/s]   [optional]
tracker.*    time, target_x, target_y, target_z [m], a point fixed to the tool          [optional]

Each has its own clock and its own rate; stamps need not be even. Missing values are empty.
"""

from pathlib import Path

import numpy as np
import pyarrow as pa

from armside.arrays import Array

from ..records.tables import READERS, read_table, write_table
from .motion import MotionRecording, Stream
from .repair import repaired

COLUMNS = {
    "imu": tuple(f"{n}_{a}" for n in ("acceleration", "angular_velocity") for a in "xyz"),
    "tracker": tuple(f"target_{a}" for a in "xyz"),
}


UNITS = {"time": "s", "motor_angle": "rad", "acceleration": "m/s²", "angular_velocity": "rad/s"}
"""Of columns by the start of their names; else metres."""


def recognised(folder: Path) -> bool:
    """True for a folder with a table of encoders."""
    return _file(folder, "encoders") is not None


def read(folder: Path) -> MotionRecording:
    """Recording of a folder. Raises ValueError for columns that are missing or damaged."""
    file = _file(folder, "encoders")
    assert file is not None
    table = read_table(file)
    motors: list[str] = []
    while f"motor_angle_{len(motors) + 1}" in table.column_names:
        motors.append(f"motor_angle_{len(motors) + 1}")
    streams: dict[str, Stream] = {}
    streams["encoders"], notes = _stream(file, table, motors or ["motor_angle_1"], "encoders")
    for name, columns in COLUMNS.items():
        if (file := _file(folder, name)) is not None:
            streams[name], more = _stream(file, read_table(file), list(columns), name)
            notes += more
    return MotionRecording(name=folder.name, form="folder of tables", notes=notes, **streams)


def _file(folder: Path, name: str) -> Path | None:
    found = (folder / f"{name}{suffix}" for suffix in READERS)
    return next((file for file in found if file.is_file()), None)


def _stream(
    file: Path, table: pa.Table, names: list[str], instrument: str
) -> tuple[Stream, tuple[str, ...]]:
    if absent := [name for name in ("time", *names) if name not in table.column_names]:
        raise ValueError(f"{file.name}: columns are missing: {', '.join(absent)}")

    def numbers(name: str) -> Array:
        try:
            column = table[name].cast(pa.float64())
        except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
            raise ValueError(f"{file.name}: {error}") from error
        return np.array(column.to_numpy(zero_copy_only=False), dtype=np.float64)

    values = np.column_stack([numbers(name) for name in names])
    return repaired(instrument, numbers("time"), values)


def write(folder: Path, recording: MotionRecording, kind: str) -> None:
    """Write a recording's tables into a folder, in files of a kind such as csv."""
    columns = dict(COLUMNS)
    n = recording.encoders.values.shape[1]
    columns["encoders"] = tuple(f"motor_angle_{i}" for i in range(1, n + 1))
    for name, own in columns.items():
        stream = getattr(recording, name)
        if stream is not None:
            write_table(folder / f"{name}.{kind}", _of_stream(stream, own))


def _of_stream(stream: Stream, columns: tuple[str, ...]) -> pa.Table:
    names = ("time", *columns)
    unit = {name: next((u for k, u in UNITS.items() if name.startswith(k)), "m") for name in names}
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit[name]}) for name in names]
    arrays = [pa.array(column) for column in (stream.time, *stream.values.T)]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))
