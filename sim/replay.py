"""`replay.rrd`: the runs of an experiment for the Rerun viewer, sent as columns.

Two timelines. `time` lays the runs one after the other; `iteration` holds the last state of each,
so its slider compares the paths learned. Nothing is shown, spawned or sent anywhere: a file is
written.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import ArrayLike, NDArray

import kinematics

from .atomic import atomic
from .geoms import body_entity, shapes
from .motion.path import Plane
from .recording import Recording
from .signals import Run

Array = NDArray[np.float64]

FRAME_PERIOD = 0.02
"""Of the robot's pose in the replay [s]."""
MAGNIFICATIONS = (50.0, 20.0, 10.0, 5.0, 2.0)
GREY, BLUE, ORANGE, GREEN = [150, 150, 150], [70, 130, 230], [240, 120, 20], [60, 170, 90]
AXIS_NAMES = [f"axis {i}" for i in range(1, 7)]


class Programmed(Protocol):
    """What the tool was asked to do."""

    @property
    def plane(self) -> Plane: ...
    def position_at(self, time: ArrayLike) -> Array: ...
    def is_on_contour(self, time: ArrayLike) -> NDArray[np.bool_]: ...


def write_replay(
    path: Path,
    mj: mujoco.MjModel,
    runs: Sequence[Run],
    motion: Programmed,
    robot: kinematics.Robot,
    *,
    magnification: float | None = None,
) -> None:
    """Write a replay, whole or not at all.

    Args:
        path: the file to write.
        mj: the model of the runs; their qpos must be its.
        runs: the iterations, in order.
        motion: the programmed path.
        robot: D-H description, which places the tool as the motors alone would have it.
        magnification: how much deviations from the path are enlarged in the plane view. By default
            50, or the largest of 20, 10, 5, 2, 1 that keeps the drawing within the contour's size.
    """
    if not runs:
        raise ValueError("a replay needs at least one run")
    if (nq := runs[0].recording.truth.qpos.shape[1]) != mj.nq:
        raise ValueError(f"the runs have {nq} joint positions, the model has {mj.nq}")
    compiled = kinematics.compile(robot)
    contours = [_Contour(run, motion, compiled) for run in runs]
    factor = magnification or _magnification(contours)
    stream = rr.RecordingStream("armside", send_properties=False)
    with atomic(path) as partial:
        stream.save(partial, default_blueprint=_blueprint(factor, motion.plane.origin))
        _send_static(stream, mj, contours[0])
        start = 0.0
        for run, contour in zip(runs, contours, strict=True):
            send_bodies(stream, mj, run, start)
            _send_contour(stream, run.k, contour, factor, start)
            _send_series(stream, run, contour, start)
            start += float(run.recording.time[-1]) + FRAME_PERIOD
        stream.flush()
        stream.disconnect()


class _Contour:
    """Programmed, motor-side and true tool path of one run in the plane, at the log's instants."""

    def __init__(self, run: Run, motion: Programmed, robot: kinematics.CompiledRobot) -> None:
        recording, plane = run.recording, motion.plane
        self.time = recording.time
        self.programmed = plane.from_base(motion.position_at(self.time))[:, :2]
        self.cutting = motion.is_on_contour(self.time)
        self.normal = _normals(self.programmed)
        motor = robot.pose(recording.motor_angle)[:, :3, 3]
        self.motor = self._deviation(plane.from_base(motor)[:, :2])
        self.tool = self._deviation(plane.from_base(_at_log(recording))[:, :2])

    def _deviation(self, p: Array) -> Array:
        """(N,) [m], across the path, outwards on a counter-clockwise contour.

        The mean offset while cutting (static deflection) is taken off first: what is left is shape.
        """
        offset = p - self.programmed
        offset = offset - offset[self.cutting].mean(axis=0)
        return np.einsum("ij,ij->i", offset, self.normal)

    def magnified(self, deviation: Array, factor: float) -> Array:
        """(N, 2) [mm], y upwards in Rerun's picture axes, which point down."""
        p = self.programmed + factor * deviation[:, np.newaxis] * self.normal
        return 1e3 * p * [1.0, -1.0]


def _normals(p: Array) -> Array:
    """Unit normals to the right of a path (N, 2); at rest that of the nearest moving sample."""
    step = np.gradient(p, axis=0)
    length = np.linalg.norm(step, axis=1)
    moving = np.flatnonzero(length > 1e-9)
    if not len(moving):
        return np.tile([1.0, 0.0], (len(p), 1))
    nearest = moving[np.clip(np.searchsorted(moving, np.arange(len(p))), 0, len(moving) - 1)]
    tangent = step[nearest] / length[nearest, np.newaxis]
    return np.column_stack([tangent[:, 1], -tangent[:, 0]])


def _at_log(recording: Recording) -> Array:
    """True tool position at the log's instants, (N, 3)."""
    row = np.searchsorted(recording.truth.time, recording.time - 1e-9)
    return recording.truth.tool_position[row]


def _magnification(contours: Sequence[_Contour]) -> float:
    first = contours[0]
    half_size = np.ptp(first.programmed, axis=0).max() / 2
    largest = max(np.abs(c.tool[c.cutting]).max() for c in contours)
    fitting = [m for m in MAGNIFICATIONS if m * largest <= half_size]
    return fitting[0] if fitting else 1.0


def _indexes(time: Array, k: int) -> list[rr.TimeColumn]:
    return [
        rr.TimeColumn("time", duration=time),
        rr.TimeColumn("iteration", sequence=np.full(len(time), k)),
    ]


def _send_static(stream: rr.RecordingStream, mj: mujoco.MjModel, contour: _Contour) -> None:
    """What does not change: shapes, the programmed path, the names of the series."""
    stream.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for entity, shape in shapes(mj):
        stream.log(entity, shape, static=True)
    programmed = contour.magnified(np.zeros(len(contour.time)), 1.0)
    line = rr.LineStrips2D([programmed], colors=GREY, labels=["programmed"], show_labels=False)
    stream.log("plane/programmed", line, static=True)
    for entity in ("motor_error", "correction", "motor_torque"):
        stream.log(entity, rr.SeriesLines(names=AXIS_NAMES), static=True)
    names = ["tool", "motors"]
    stream.log("arm_error", rr.SeriesLines(names=names, colors=[ORANGE, BLUE]), static=True)


def send_bodies(stream: rr.RecordingStream, mj: mujoco.MjModel, run: Run, start: float) -> None:
    """Poses of all bodies over time, from the joint positions."""
    truth = run.recording.truth
    every = max(1, round(FRAME_PERIOD / (truth.time[1] - truth.time[0])))
    frames, time = truth.qpos[::every], start + truth.time[::every]
    position, quaternion = (
        np.empty((len(frames), mj.nbody, 3)),
        np.empty((len(frames), mj.nbody, 4)),
    )
    data = mujoco.MjData(mj)
    for i, qpos in enumerate(frames):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(mj, data)
        position[i], quaternion[i] = data.xpos, data.xquat
    indexes = _indexes(time, run.k)
    for body in range(1, mj.nbody):
        columns = rr.Transform3D.columns(
            translation=position[:, body], quaternion=np.roll(quaternion[:, body], -1, axis=1)
        )
        stream.send_columns(body_entity(mj, body), indexes, columns)


def _send_contour(
    stream: rr.RecordingStream, k: int, contour: _Contour, factor: float, start: float
) -> None:
    """The magnified paths of one iteration, and the tool moving along its own."""
    indexes = _indexes(np.array([start]), k)
    for name, deviation, colour in (
        ("motors", contour.motor, BLUE),
        ("tool", contour.tool, ORANGE),
    ):
        strip = contour.magnified(deviation, factor)[contour.cutting]
        columns = rr.LineStrips2D.columns(strips=[strip], colors=[colour])
        stream.send_columns(f"plane/{name}", indexes, columns)
    every = max(1, round(FRAME_PERIOD / (contour.time[1] - contour.time[0])))
    point = contour.magnified(contour.tool, factor)[::every]
    columns = rr.Points2D.columns(positions=point, colors=[ORANGE] * len(point))
    stream.send_columns("plane/tool_now", _indexes(start + contour.time[::every], k), columns)


def _send_series(stream: rr.RecordingStream, run: Run, contour: _Contour, start: float) -> None:
    """Errors, corrections and torques at the log rate; six lines of an entity each."""
    recording = run.recording
    arm_error = np.where(contour.cutting, [contour.tool, contour.motor], np.nan).T
    indexes = _indexes(start + recording.time, run.k)
    for entity, values in (
        ("motor_error", 1e3 * recording.error),
        ("correction", 1e3 * recording.correction),
        ("motor_torque", recording.motor_torque),
        ("arm_error", 1e6 * arm_error),
    ):
        n, width = values.shape
        columns = rr.Scalars.columns(scalars=values.ravel()).partition(np.full(n, width))
        stream.send_columns(entity, indexes, columns)


def _blueprint(factor: float, target: Array) -> rrb.Blueprint:
    """Robot and plane beside the series; the camera looks at the contour from the side."""
    eye = rrb.EyeControls3D(
        position=target + np.array([0.8, -3.6, 0.6]), look_target=target - np.array([0.7, 0, 0.5])
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="/", contents="robot/**", name="Robot", eye_controls=eye),
                rrb.Spatial2DView(
                    origin="plane", name=f"Contour, deviation x{factor:g} [mm, y up]"
                ),
            ),
            rrb.Vertical(
                rrb.TimeSeriesView(origin="motor_error", name="Motor error, arm side [mrad]"),
                rrb.TimeSeriesView(origin="arm_error", name="Deviation across the path [um]"),
                rrb.TimeSeriesView(origin="correction", name="Correction u, arm side [mrad]"),
                rrb.TimeSeriesView(origin="motor_torque", name="Motor torque [N m]"),
            ),
        ),
        rrb.TimePanel(timeline="time"),
        collapse_panels=True,
    )
