"""Files of an IMU experiment: `imu.parquet` with its samples, and `replay.rrd`."""

import json
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from armside.arrays import Array

from ..records.atomic import atomic
from ..records.signals import RecordedRun
from ..replay.blueprint import LEGEND, panels
from ..replay.entities import BLUE, FRAME_PERIOD, GREY, ORANGE, send_bodies, shapes
from ..replay.scene import recording
from .imu_experiment import ImuResult
from .phases import Evaluation

XYZ = "xyz"


def write_imu_signals(
    path: Path, results: Sequence[ImuResult], *, config: Mapping[str, Any]
) -> None:
    """Write the IMU samples of programs k = 0, 1, ... that lie within their robot's log.

    The IMU has its own clock: `imu_time` is by that clock, `time` is the robot time that the
    synchronisation assigns. Units stand in the metadata of each column.
    """
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


COLOURS = {"measured": ORANGE, "predicted": BLUE}
PANELS = (
    ("acceleration", "Acceleration of the IMU, base axes [m/s^2]"),
    ("angular_velocity", "Angular velocity of the IMU, base axes [rad/s]"),
)


def write_imu_replay(path: Path, results: Sequence[ImuResult]) -> None:
    """Write the runs one after the other on the timeline `time`, whole or not at all."""
    mj = results[0].planned.loaded.model.mj
    with recording(path, _blueprint()) as stream:
        stream.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for entity, shape in shapes(mj):
            stream.log(entity, shape, static=True)
        for kind, axis, (name, colour) in product(dict(PANELS), XYZ, COLOURS.items()):
            lines = rr.SeriesLines(names=f"{name} {axis}", colors=colour)
            stream.log(f"{kind}_{axis}/{name}", lines, static=True)
        stream.log("acceleration_error_rms", rr.SeriesLines(names=list(XYZ)), static=True)
        start = 0.0
        for k, result in enumerate(results):
            log = result.run.recording
            send_bodies(stream, mj, RecordedRun(k=k, recording=log), start)
            _send_evaluation(stream, result.evaluation, start)
            start += float(log.time[-1]) + FRAME_PERIOD


def _send_evaluation(stream: rr.RecordingStream, evaluation: Evaluation, start: float) -> None:
    """Path of the tool over the whole run, shown from its start, and the series."""
    path = rr.LineStrips3D.columns(strips=[evaluation.tool[::5]], colors=[GREY])
    stream.send_columns("robot/path", [rr.TimeColumn("time", duration=np.array([start]))], path)
    comparison = evaluation.comparison
    index = rr.TimeColumn("time", duration=start + comparison.time)
    for kind, name, (i, axis) in product(dict(PANELS), COLOURS, enumerate(XYZ)):
        values: Array = getattr(comparison, f"{kind}_{name}")
        columns = rr.Scalars.columns(scalars=values[:, i])
        stream.send_columns(f"{kind}_{axis}/{name}", [index], columns)
    n, width = evaluation.window_rms.shape
    columns = rr.Scalars.columns(scalars=evaluation.window_rms.ravel())
    stream.send_columns("acceleration_error_rms", [index], columns.partition(np.full(n, width)))


def _blueprint() -> rrb.Blueprint:
    def view(entity: str, title: str) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(origin=entity, name=title, plot_legend=LEGEND)

    of_axes = [
        rrb.Vertical(*(view(f"{kind}_{axis}", f"{title}, {axis}") for axis in XYZ), name=title)
        for kind, title in PANELS
    ]
    error = view("acceleration_error_rms", "Acceleration error, moving RMS [m/s^2]")
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="/", contents="robot/**", name="Robot"),
            rrb.Tabs(*of_axes, error),
        ),
        *panels(),
    )
