"""`replay.rrd`: the runs of an experiment for the Rerun viewer, sent as columns.

Two timelines. `time` lays the runs one after the other; `iteration` holds the last state of each,
so its slider compares the paths learned. Nothing is shown, spawned or sent anywhere: a file is
written.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import rerun as rr

from armside import kinematics
from armside.arrays import Array

from ..records.atomic import atomic
from ..records.signals import Run
from .blueprint import Layout, blueprint
from .geoms import body_entity, shapes
from .paths import Contour, Programmed, fitting_magnification

FRAME_PERIOD = 0.02
"""Of the robot's pose in the replay [s]."""
IMU_PERIOD = 0.01
"""Of the IMU series in the replay [s]."""
SPECTRUM_TO = 40.0
"""[Hz], above which the robot hardly moves."""
WORST_SHOWN = 3.0
"""Error as a part of the first run's that a learning curve is shown up to."""
GREY, BLUE, ORANGE = [150, 150, 150], [70, 130, 230], [240, 120, 20]
AXIS_COLOURS = [
    [0, 114, 178],
    [86, 180, 233],
    [0, 158, 115],
    [204, 121, 167],
    [150, 110, 190],
    [120, 120, 120],
]
"""Of axes 1 to 6: none is orange, which is the tool's."""
AXIS_NAMES = [f"axis {i}" for i in range(1, 7)]
XYZ = ["x", "y", "z"]
SERIES = {
    "motor_error": (AXIS_NAMES, AXIS_COLOURS),
    "correction": (AXIS_NAMES, AXIS_COLOURS),
    "motor_torque": (AXIS_NAMES, AXIS_COLOURS),
    "arm_error": (["tool", "motors"], [ORANGE, BLUE]),
    "imu/acceleration": (XYZ, AXIS_COLOURS[:3]),
    "imu/angular_velocity": (XYZ, AXIS_COLOURS[:3]),
    "tracker": (XYZ, AXIS_COLOURS[:3]),
}
TOOL_LINES = ("tool RMS", "tool maximum")
"""Learning curves that are the tool's; all others are a motor's."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One experiment as a replay shows it."""

    mj: mujoco.MjModel
    """The model of the runs; their qpos must be its."""
    runs: Sequence[Run]
    """The iterations, in order."""
    motion: Programmed
    robot: kinematics.Robot
    """D-H description, which places the tool as the motors alone would have it."""
    name: str = ""
    """Tells experiments apart that are shown side by side."""
    about: str = ""
    """Markdown: the design, the measures."""
    learning: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """By the name of the line, for each run the part of the first run's error that is left."""

    def __post_init__(self) -> None:
        if not self.runs:
            raise ValueError("a replay needs at least one run")
        if (nq := self.runs[0].recording.truth.qpos.shape[1]) != self.mj.nq:
            raise ValueError(f"the runs have {nq} joint positions, the model has {self.mj.nq}")
        for name, values in self.learning.items():
            if len(values) != len(self.runs):
                raise ValueError(
                    f"learning {name!r} has {len(values)} values for {len(self.runs)} runs"
                )

    def entity(self, path: str) -> str:
        """Where something of this experiment lives among the entities."""
        return f"{self.name}/{path}" if self.name else path


def write_replay(
    path: Path,
    mj: mujoco.MjModel,
    runs: Sequence[Run],
    motion: Programmed,
    robot: kinematics.Robot,
    *,
    magnification: float | None = None,
    about: str = "",
    learning: Mapping[str, Sequence[float]] | None = None,
) -> None:
    """Write the replay of one experiment; see `Scene` and `write_scenes` for the arguments."""
    scene = Scene(
        mj=mj, runs=runs, motion=motion, robot=robot, about=about, learning=learning or {}
    )
    write_scenes(path, [scene], magnification=magnification)


def write_scenes(
    path: Path, scenes: Sequence[Scene], *, magnification: float | None = None
) -> None:
    """Write one or more experiments side by side, whole or not at all.

    Their iterations start together.

    Args:
        path: the file to write.
        scenes: the experiments; names must differ.
        magnification: how much deviations from the path are enlarged. By default 50, or the
            largest of 20, 10, 5, 2, 1 that leaves the contour's shape to be seen.

    Raises:
        ValueError: no scene, two of one name, or a magnification that is not above 0.
    """
    names = [scene.name for scene in scenes]
    if not scenes or len(set(names)) != len(names):
        raise ValueError(f"a replay needs experiments of different names, got {names}")
    if magnification is not None and not (np.isfinite(magnification) and magnification > 0.0):
        raise ValueError(f"magnification must be > 0, got {magnification:g}")
    contours = [_contours(scene) for scene in scenes]
    factor = magnification or min(fitting_magnification(own) for own in contours)
    worst = _worst(scenes)
    layouts = [_layout(scene, factor, worst) for scene in scenes]
    starts = _starts(scenes)
    stream = rr.RecordingStream("armside", send_properties=False)
    with atomic(path) as partial:
        stream.save(partial, default_blueprint=blueprint(layouts))
        for scene, own in zip(scenes, contours, strict=True):
            _send_scene(stream, scene, own, factor, starts)
        stream.flush()
        stream.disconnect()


def _contours(scene: Scene) -> list[Contour]:
    compiled = kinematics.compile(scene.robot)
    return [Contour(run, scene.motion, compiled) for run in scene.runs]


def _starts(scenes: Sequence[Scene]) -> Array:
    """When each iteration starts [s]: after the longest of the one before."""
    most = max(len(scene.runs) for scene in scenes)
    last = np.zeros(most)
    for scene in scenes:
        for i, run in enumerate(scene.runs):
            last[i] = max(last[i], run.recording.time[-1])
    return np.concatenate([[0.0], np.cumsum(last[:-1] + FRAME_PERIOD)])


def _worst(scenes: Sequence[Scene]) -> float:
    """Largest value of all learning curves [%], up to what still leaves the others to be seen."""
    values = np.array([x for scene in scenes for curve in scene.learning.values() for x in curve])
    finite = values[np.isfinite(values)]
    return 100.0 * float(np.clip(finite.max(initial=1.0), 1.0, WORST_SHOWN))


def _layout(scene: Scene, factor: float, worst: float) -> Layout:
    data = mujoco.MjData(scene.mj)
    data.qpos[:] = scene.runs[0].recording.truth.qpos[0]
    mujoco.mj_kinematics(scene.mj, data)
    return Layout(
        name=scene.name,
        factor=factor,
        target=scene.motion.plane.origin,
        height=float(data.geom_xpos[:, 2].max()),
        worst=worst,
    )


def _send_scene(
    stream: rr.RecordingStream,
    scene: Scene,
    contours: Sequence[Contour],
    factor: float,
    starts: Array,
) -> None:
    _send_static(stream, scene, contours[0])
    _send_paths(stream, scene, contours, factor, starts)
    _send_learning(stream, scene, starts)
    for run, contour, start in zip(scene.runs, contours, starts, strict=False):
        send_bodies(stream, scene.mj, run, float(start), prefix=scene.entity("robot"))
        _send_contour(stream, scene, run.k, contour, factor, float(start))
        _send_series(stream, scene, run, contour, float(start))
        _send_spectrum(stream, scene, run.k, contour, float(start))


def _indexes(time: Array, k: int) -> list[rr.TimeColumn]:
    return [
        rr.TimeColumn("time", duration=time),
        rr.TimeColumn("iteration", sequence=np.full(len(time), k)),
    ]


def _send_static(stream: rr.RecordingStream, scene: Scene, contour: Contour) -> None:
    """What does not change: shapes, the programmed path, the names of the series, the text."""
    stream.log(scene.entity("robot"), rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for entity, shape in shapes(scene.mj, prefix=scene.entity("robot")):
        stream.log(entity, shape, static=True)
    programmed = contour.magnified(np.zeros(len(contour.time)), 1.0)
    line = rr.LineStrips2D([programmed], colors=GREY, labels=["programmed"], show_labels=False)
    stream.log(scene.entity("plane/programmed"), line, static=True)
    for entity, (names, colours) in SERIES.items():
        lines = rr.SeriesLines(names=names, colors=colours)
        stream.log(scene.entity(entity), lines, static=True)
    if scene.about:
        text = rr.TextDocument(scene.about, media_type="text/markdown")
        stream.log(scene.entity("about"), text, static=True)


def send_bodies(
    stream: rr.RecordingStream, mj: mujoco.MjModel, run: Run, start: float, prefix: str = "robot"
) -> None:
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
        stream.send_columns(body_entity(mj, body, prefix), indexes, columns)


def _send_paths(
    stream: rr.RecordingStream,
    scene: Scene,
    contours: Sequence[Contour],
    factor: float,
    starts: Array,
) -> None:
    """All iterations beside each other, always in sight; a point runs along the present one."""
    columns = min(3, len(contours))
    pitch = 1e3 * contours[0].half_size * 3.3  # [mm], leaves room for a label
    places = [np.array([i % columns, i // columns]) * pitch for i in range(len(contours))]
    now = scene.entity("paths/now")
    for name, colour in (("programmed", GREY), ("motors", BLUE), ("tool", ORANGE)):
        strips = []
        for contour, place in zip(contours, places, strict=True):
            deviation = {"motors": contour.motor, "tool": contour.tool}.get(
                name, np.zeros(len(contour.time))
            )
            strips.append(contour.magnified(deviation, factor)[contour.cutting] + place)
        stream.log(
            scene.entity(f"paths/{name}"), rr.LineStrips2D(strips, colors=colour), static=True
        )
    heads = [place - np.array([0.0, 0.46 * pitch]) for place in places]
    labels = [f"k = {run.k}" for run in scene.runs]
    dots = rr.Points2D(heads, radii=0.001, labels=labels, colors=[60, 60, 60], show_labels=True)
    stream.log(scene.entity("paths/labels"), dots, static=True)
    for run, contour, place, start in zip(scene.runs, contours, places, starts, strict=False):
        every = max(1, round(FRAME_PERIOD / (contour.time[1] - contour.time[0])))
        point = (contour.magnified(contour.tool, factor) + place)[::every]
        columns_ = rr.Points2D.columns(positions=point, colors=[ORANGE] * len(point))
        stream.send_columns(now, _indexes(start + contour.time[::every], run.k), columns_)


def _send_contour(
    stream: rr.RecordingStream, scene: Scene, k: int, contour: Contour, factor: float, start: float
) -> None:
    """The magnified paths of one iteration, and the tool moving along its own."""
    indexes = _indexes(np.array([start]), k)
    for name, deviation, colour in (
        ("motors", contour.motor, BLUE),
        ("tool", contour.tool, ORANGE),
    ):
        strip = contour.magnified(deviation, factor)[contour.cutting]
        columns = rr.LineStrips2D.columns(strips=[strip], colors=[colour])
        stream.send_columns(scene.entity(f"plane/{name}"), indexes, columns)
    every = max(1, round(FRAME_PERIOD / (contour.time[1] - contour.time[0])))
    point = contour.magnified(contour.tool, factor)[::every]
    columns = rr.Points2D.columns(positions=point, colors=[ORANGE] * len(point))
    now = scene.entity("plane/tool_now")
    stream.send_columns(now, _indexes(start + contour.time[::every], k), columns)


def _send_series(
    stream: rr.RecordingStream, scene: Scene, run: Run, contour: Contour, start: float
) -> None:
    """Errors, corrections and torques at the log rate, sensors at their own."""
    recording = run.recording
    truth, tracker = recording.truth, run.tracker
    arm_error = np.where(contour.cutting, [contour.tool, contour.motor], np.nan).T
    log = recording.time
    every = max(1, round(IMU_PERIOD / (truth.time[1] - truth.time[0])))
    series = [
        ("motor_error", log, 1e3 * recording.error),
        ("correction", log, 1e3 * recording.correction),
        ("motor_torque", log, recording.motor_torque),
        ("arm_error", log, 1e6 * arm_error),
        ("imu/acceleration", truth.time[::every], truth.imu_acceleration[::every]),
        ("imu/angular_velocity", truth.time[::every], truth.imu_angular_velocity[::every]),
    ]
    if tracker is not None:
        # A lost beam is a gap.
        place = np.where(tracker.valid[:, np.newaxis], tracker.position, np.nan)
        series.append(("tracker", tracker.time, 1e3 * (place - scene.motion.plane.origin)))
    for entity, time, values in series:
        n, width = values.shape
        columns = rr.Scalars.columns(scalars=values.ravel()).partition(np.full(n, width))
        stream.send_columns(scene.entity(entity), _indexes(start + time, run.k), columns)


def _send_learning(stream: rr.RecordingStream, scene: Scene, starts: Array) -> None:
    """The learning curves [%]: a stair over time, a point for each iteration."""
    ks = [run.k for run in scene.runs]
    n = len(scene.runs)
    ends = [starts[i] + run.recording.time[-1] for i, run in enumerate(scene.runs)]
    time = np.column_stack([starts[:n], ends]).ravel()
    indexes = [
        rr.TimeColumn("time", duration=time),
        rr.TimeColumn("iteration", sequence=np.repeat(ks, 2)),
    ]
    motors = iter(AXIS_COLOURS)
    for name, values in scene.learning.items():
        tool = name in TOOL_LINES
        colour = ([240, 180, 60] if name.endswith("maximum") else ORANGE) if tool else next(motors)
        entity = scene.entity(f"learning/{name.replace(' ', '_')}")
        lines = rr.SeriesLines(names=name, colors=colour, widths=3.0 if tool else 1.5)
        stream.log(entity, lines, static=True)
        columns = rr.Scalars.columns(scalars=100.0 * np.repeat(values, 2))
        stream.send_columns(entity, indexes, columns)


def _send_spectrum(
    stream: rr.RecordingStream, scene: Scene, k: int, contour: Contour, start: float
) -> None:
    """Of tool and motors across the path while cutting, for one iteration."""
    for name, deviation, colour in (
        ("motors", contour.motor, BLUE),
        ("tool", contour.tool, ORANGE),
    ):
        frequency, amplitude = contour.spectrum(deviation)
        shown = frequency <= SPECTRUM_TO
        columns = rr.BarChart.columns(
            values=[1e6 * amplitude[shown]], abscissa=[frequency[shown]], color=[colour]
        )
        indexes = _indexes(np.array([start]), k)
        stream.send_columns(scene.entity(f"spectrum/{name}"), indexes, columns)
