"""`imu.parquet`: samples of the IMU, measured and predicted motion.

The IMU has its own clock: `imu_time` is by that clock, `time` is the robot time that the
synchronisation assigns. Units stand in the metadata of each column.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..records.atomic import atomic
from .experiment import ImuResult

XYZ = "xyz"


def write_imu_signals(
    path: Path, results: Sequence[ImuResult], *, config: Mapping[str, Any]
) -> None:
    """Write the IMU samples of programs k = 0, 1, ... that lie within their robot's log."""
    table = pa.concat_tables([_table(k, result) for k, result in enumerate(results)])
    text = json.dumps(dict(config), sort_keys=True)
    table = table.replace_schema_metadata({"armside.config": text})
    with atomic(path) as partial:
        pq.write_table(table, partial, compression="zstd")


def _table(k: int, result: ImuResult) -> pa.Table:
    samples, comparison = result.run.samples, result.evaluation.comparison
    robot_time = samples.time + comparison.clock_offset
    inside = np.isin(robot_time, comparison.time)
    columns: dict[str, tuple[NDArray[Any], str]] = {
        "k": (np.full(len(comparison.time), k, dtype=np.int32), "1"),
        "time": (comparison.time, "s"),
        "imu_time": (samples.time[inside], "s"),
    }
    three = {
        "imu_acceleration": (samples.acceleration[inside], "m/s^2"),
        "imu_angular_velocity": (samples.angular_velocity[inside], "rad/s"),
        "imu_acceleration_clipped": (samples.acceleration_clipped[inside], "1"),
        "imu_angular_velocity_clipped": (samples.angular_velocity_clipped[inside], "1"),
        "acceleration_measured": (comparison.acceleration_measured, "m/s^2"),
        "acceleration_predicted": (comparison.acceleration_predicted, "m/s^2"),
        "angular_velocity_measured": (comparison.angular_velocity_measured, "rad/s"),
        "angular_velocity_predicted": (comparison.angular_velocity_predicted, "rad/s"),
        "acceleration_error_rms": (result.evaluation.window_rms, "m/s^2"),
    }
    for name, (values, unit) in three.items():
        columns |= {f"{name}_{axis}": (values[:, i], unit) for i, axis in enumerate(XYZ)}
    arrays = [pa.array(np.ascontiguousarray(values)) for values, _ in columns.values()]
    fields = [
        pa.field(name, array.type, metadata={"unit": unit})
        for array, (name, (_, unit)) in zip(arrays, columns.items(), strict=True)
    ]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))
