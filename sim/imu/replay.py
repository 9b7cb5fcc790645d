"""`replay.rrd` of an IMU experiment: the robot, its tool path, measured and predicted motion."""

from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from armside.arrays import Array

from ..records.signals import RecordedRun
from ..replay.blueprint import LEGEND, panels
from ..replay.entities import BLUE, FRAME_PERIOD, GREY, ORANGE, send_bodies, shapes
from ..replay.scene import recording
from .evaluation import Evaluation
from .experiment import ImuResult

COLOURS = {"measured": ORANGE, "predicted": BLUE}
PANELS = (
    ("acceleration", "Acceleration of the IMU, base axes [m/s^2]"),
    ("angular_velocity", "Angular velocity of the IMU, base axes [rad/s]"),
)
AXES = "xyz"


def write_imu_replay(path: Path, results: Sequence[ImuResult]) -> None:
    """Write the runs one after the other on the timeline `time`, whole or not at all."""
    mj = results[0].planned.loaded.model.mj
    with recording(path, _blueprint()) as stream:
        _send_static(stream, mj)
        start = 0.0
        for k, result in enumerate(results):
            log = result.run.recording
            send_bodies(stream, mj, RecordedRun(k=k, recording=log), start)
            _send_path(stream, result.evaluation, start)
            _send_series(stream, result.evaluation, start)
            start += float(log.time[-1]) + FRAME_PERIOD


def _send_static(stream: rr.RecordingStream, mj: mujoco.MjModel) -> None:
    stream.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for entity, shape in shapes(mj):
        stream.log(entity, shape, static=True)
    for kind, _ in PANELS:
        for axis in AXES:
            for name, colour in COLOURS.items():
                lines = rr.SeriesLines(names=f"{name} {axis}", colors=colour)
                stream.log(f"{kind}_{axis}/{name}", lines, static=True)
    stream.log("acceleration_error_rms", rr.SeriesLines(names=list(AXES)), static=True)


def _send_path(stream: rr.RecordingStream, evaluation: Evaluation, start: float) -> None:
    """Path of the tool over the whole run, shown from its start."""
    columns = rr.LineStrips3D.columns(strips=[evaluation.tool[::5]], colors=[GREY])
    index = rr.TimeColumn("time", duration=np.array([start]))
    stream.send_columns("robot/path", [index], columns)


def _send_series(stream: rr.RecordingStream, evaluation: Evaluation, start: float) -> None:
    comparison = evaluation.comparison
    index = rr.TimeColumn("time", duration=start + comparison.time)
    for kind, _ in PANELS:
        for name in COLOURS:
            values: Array = getattr(comparison, f"{kind}_{name}")
            for i, axis in enumerate(AXES):
                columns = rr.Scalars.columns(scalars=values[:, i])
                stream.send_columns(f"{kind}_{axis}/{name}", [index], columns)
    n, width = evaluation.window_rms.shape
    columns = rr.Scalars.columns(scalars=evaluation.window_rms.ravel())
    stream.send_columns("acceleration_error_rms", [index], columns.partition(np.full(n, width)))


def _blueprint() -> rrb.Blueprint:
    def view(entity: str, title: str) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(origin=entity, name=title, plot_legend=LEGEND)

    of_axes = [
        rrb.Vertical(*(view(f"{kind}_{axis}", f"{title}, {axis}") for axis in AXES), name=title)
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
