"""Entities of a replay: robot, tool paths, signals and learning curves as Rerun columns."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
import rerun as rr
from mujoco import mjtGeom

from armside.arrays import Array

from ..records.signals import RecordedRun
from .blueprint import Layout
from .paths import Contour

LARGEST_VISUAL_GROUP = 2
"""MuJoCo's viewers show groups 0 to 2; by convention collision shapes are in 3."""
FLOOR = 3.0
"""Half side of an infinite plane as drawn [m]."""
FRAME_PERIOD = 0.02
"""Period of the robot's pose in the replay [s]."""
IMU_PERIOD = 0.01
"""Period of the IMU series in the replay [s]."""
SPECTRUM_TO = 40.0
"""Largest frequency shown [Hz]; above it the robot hardly moves."""
GREY, BLUE, ORANGE, INK = [150, 150, 150], [70, 130, 230], [240, 120, 20], [60, 60, 60]
TOOL_MAXIMUM = [240, 180, 60]
AXIS_RGB = (
    *("0072B2", "56B4E9", "009E73", "CC79A7", "966EBE", "787878"),
    *("332288", "882255", "999933"),
)
AXIS_COLOURS = [[*bytes.fromhex(rgb)] for rgb in AXIS_RGB]
"""Colours of axes 1 to 9: none is orange, which is the tool's."""
OF_AXES = ("motor_error", "correction", "motor_torque")
"""Series with a line for each axis."""
OF_XYZ = {"names": ["x", "y", "z"], "colors": AXIS_COLOURS[:3]}
OTHERS: Mapping[str, Mapping[str, Any]] = {
    "arm_error": {"names": ["tool", "motors"], "colors": [ORANGE, BLUE]},
    **dict.fromkeys(("imu/acceleration", "imu/angular_velocity", "tracker"), OF_XYZ),
}
THIN, THICK = -0.4, -1.5
"""Half widths of rapid moves and of a part's tool path; below 0 they are points of the screen."""
COLOURED = 5
"""Samples of a part's tool path in one colour."""
TOOL_LINES = ("tool RMS", "tool maximum")
"""Learning curves of the tool; all others are of a motor."""


class Entities:
    """Entities of one experiment in a stream, below its name where it has one."""

    def __init__(self, stream: rr.RecordingStream, layout: Layout) -> None:
        self.stream, self.layout = stream, layout

    def static(self, path: str, shape: rr.AsComponents) -> None:
        """Log a shape that does not change."""
        self.stream.log(self.layout.entity(path), shape, static=True)

    def send(
        self, path: str, time: Array | float, k: int | Array, columns: rr.ComponentColumnList
    ) -> None:
        """Send columns with a row for each time [s] of iteration k."""
        indexes = _indexes(np.atleast_1d(time), k)
        self.stream.send_columns(self.layout.entity(path), indexes, columns)


def _indexes(time: Array, k: int | Array) -> list[rr.TimeColumn]:
    ks = np.broadcast_to(k, len(time))
    return [rr.TimeColumn("time", duration=time), rr.TimeColumn("iteration", sequence=ks)]


def _every(time: Array, period: float) -> slice:
    return slice(None, None, max(1, round(period / (time[1] - time[0]))))


def _sides(contour: Contour) -> tuple[tuple[str, Array, list[int]], ...]:
    """Name, deviation across the path and colour of both sides of the gears."""
    return ("motors", contour.motor, BLUE), ("tool", contour.tool, ORANGE)


def send_static(
    to: Entities, mj: mujoco.MjModel, contour: Contour, about: str, n_axes: int
) -> None:
    """Send shapes, programmed path, names of the series and text, which do not change."""
    to.static("robot", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for entity, shape in shapes(mj, prefix=to.layout.entity("robot")):
        to.stream.log(entity, shape, static=True)
    way = contour.magnified(0.0, 1.0)
    programmed = contour.cut(0.0, 1.0) if contour.is_part else [way]
    names = ["programmed"] * len(programmed)
    line = rr.LineStrips2D(programmed, colors=GREY, labels=names, show_labels=False)
    to.static("plane/programmed", line)
    if contour.is_part:
        moves = [way[span] for span in contour.between]
        to.static("plane/rapid", rr.LineStrips2D(moves, colors=GREY, radii=THIN))
    axes = [f"axis {i + 1}" for i in range(n_axes)]
    for path in OF_AXES:
        to.static(path, rr.SeriesLines(names=axes, colors=AXIS_COLOURS[:n_axes]))
    for path, lines in OTHERS.items():
        to.static(path, rr.SeriesLines(**lines))
    if about:
        to.static("about", rr.TextDocument(about, media_type="text/markdown"))


def send_bodies(
    stream: rr.RecordingStream,
    mj: mujoco.MjModel,
    run: RecordedRun,
    start: float,
    prefix: str = "robot",
) -> None:
    """Send poses of all bodies over time, by forward kinematics of the joint positions."""
    truth = run.recording.truth
    every = _every(truth.time, FRAME_PERIOD)
    frames, time = truth.qpos[every], start + truth.time[every]
    position, quaternion = (np.empty((len(frames), mj.nbody, n)) for n in (3, 4))
    data = mujoco.MjData(mj)
    for i, qpos in enumerate(frames):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(mj, data)
        position[i], quaternion[i] = data.xpos, data.xquat
    indexes, quaternion = _indexes(time, run.k), np.roll(quaternion, -1, axis=2)
    for body in range(1, mj.nbody):
        p, q = position[:, body], quaternion[:, body]
        columns = rr.Transform3D.columns(translation=p, quaternion=q)
        stream.send_columns(body_entity(mj, body, prefix), indexes, columns)


def send_paths(
    to: Entities, runs: Sequence[RecordedRun], contours: Sequence[Contour], starts: Array
) -> None:
    """Send all iterations beside each other, always visible; a point runs along the current one."""
    columns = min(3, len(contours))
    pitch = 1e3 * contours[0].half_size * 3.3  # [mm], leaves room for a label
    places = [np.array([i % columns, i // columns]) * pitch for i in range(len(contours))]
    strips: dict[str, list[Array]] = {"programmed": [], "motors": [], "tool": []}
    for run, contour, place, start in zip(runs, contours, places, starts, strict=False):
        sides = () if contour.is_part else _sides(contour)
        for name, deviation, _ in (("programmed", 0.0, GREY), *sides):
            strips[name] += [line + place for line in contour.cut(deviation, to.layout.factor)]
        if contour.is_part:
            pieces, colours = contour.coloured(to.layout.factor, COLOURED)
            lines = rr.LineStrips2D([line + place for line in pieces], colors=colours, radii=THICK)
            to.static(f"paths/tool_{run.k}", lines)
        _send_point(to, "paths/now", run.k, contour, start, place)
    for (name, lines), colour in zip(strips.items(), (GREY, BLUE, ORANGE), strict=True):
        to.static(f"paths/{name}", rr.LineStrips2D(lines, colors=colour))
    heads = [place - np.array([0.0, 0.46 * pitch]) for place in places]
    labels = [f"k = {r.k}{_scale(c)}" for r, c in zip(runs, contours, strict=True)]
    shown = rr.Points2D(heads, radii=0.001, labels=labels, colors=INK, show_labels=True)
    to.static("paths/labels", shown)


def send_contour(to: Entities, k: int, contour: Contour, start: float) -> None:
    """Send the magnified paths of one iteration, and the tool moving along its own."""
    if contour.is_part:
        strips, colours = contour.coloured(to.layout.factor, COLOURED)
        columns = rr.LineStrips2D.columns(
            strips=strips, colors=colours, radii=[THICK] * len(strips)
        )
        to.send("plane/tool", start, k, columns.partition([len(strips)]))
        top = contour.magnified(0.0, 1.0).min(axis=0)  # y points down
        said = rr.Points2D.columns(positions=[top], labels=[f"k = {k}{_scale(contour)}"])
        to.send("plane/scale", start, k, said)
    else:
        for name, deviation, colour in _sides(contour):
            strips = contour.cut(deviation, to.layout.factor)
            columns = rr.LineStrips2D.columns(strips=strips, colors=[colour])
            to.send(f"plane/{name}", start, k, columns)
    _send_point(to, "plane/tool_now", k, contour, start)


def _scale(contour: Contour) -> str:
    """Largest deviation that the colours of a part's path stand for."""
    if not contour.is_part:
        return ""
    return f": blue −{1e6 * contour.worst:.0f} µm, grey 0, red {1e6 * contour.worst:.0f} µm"


def _send_point(
    to: Entities, path: str, k: int, contour: Contour, start: float, place: Array | float = 0.0
) -> None:
    every = _every(contour.time, FRAME_PERIOD)
    point = (contour.magnified(contour.tool, to.layout.factor) + place)[every]
    columns = rr.Points2D.columns(positions=point, colors=[ORANGE] * len(point))
    to.send(path, start + contour.time[every], k, columns)


def send_series(to: Entities, run: RecordedRun, contour: Contour, start: float) -> None:
    """Send errors, corrections and torques at the log rate, sensors at their own."""
    recording, tracker = run.recording, run.tracker
    truth, log = recording.truth, recording.time
    arm_error = np.where(contour.cutting, [contour.tool, contour.motor], np.nan).T
    every = _every(truth.time, IMU_PERIOD)
    imu = truth.time[every]
    series = [
        ("motor_error", log, 1e3 * recording.error),
        ("correction", log, 1e3 * recording.correction),
        ("motor_torque", log, recording.motor_torque),
        ("arm_error", log, 1e6 * arm_error),
        ("imu/acceleration", imu, truth.imu_acceleration[every]),
        ("imu/angular_velocity", imu, truth.imu_angular_velocity[every]),
    ]
    if tracker is not None:
        # A lost beam is a gap.
        position = np.where(tracker.valid[:, np.newaxis], tracker.position, np.nan)
        series.append(("tracker", tracker.time, 1e3 * (position - to.layout.target)))
    for path, time, values in series:
        n, width = values.shape
        columns = rr.Scalars.columns(scalars=values.ravel()).partition(np.full(n, width))
        to.send(path, start + time, run.k, columns)


def send_learning(
    to: Entities, runs: Sequence[RecordedRun], curves: Mapping[str, Sequence[float]], starts: Array
) -> None:
    """Send the learning curves [%]: a step over time, a point for each iteration."""
    lengths = [run.recording.time[-1] for run in runs]
    time = np.column_stack([starts[: len(runs)], starts[: len(runs)] + lengths]).ravel()
    ks = np.repeat([run.k for run in runs], 2)
    motors = iter(AXIS_COLOURS)
    for name, values in curves.items():
        tool = name in TOOL_LINES
        colour = (TOOL_MAXIMUM if name.endswith("maximum") else ORANGE) if tool else next(motors)
        path = f"learning/{name.replace(' ', '_')}"
        to.static(path, rr.SeriesLines(names=name, colors=colour, widths=3.0 if tool else 1.5))
        columns = rr.Scalars.columns(scalars=100.0 * np.repeat(values, 2))
        to.send(path, time, ks, columns)


def send_spectrum(to: Entities, k: int, contour: Contour, start: float) -> None:
    """Send spectra of tool and motors across the path while cutting, for one iteration."""
    for name, deviation, colour in _sides(contour):
        frequency, amplitude = contour.spectrum(deviation)
        shown = frequency <= SPECTRUM_TO
        values, abscissa = [1e6 * amplitude[shown]], [frequency[shown]]
        columns = rr.BarChart.columns(values=values, abscissa=abscissa, color=[colour])
        to.send(f"spectrum/{name}", start, k, columns)


def body_entity(mj: mujoco.MjModel, body: int, prefix: str = "robot") -> str:
    """Entity of a body in a replay."""
    return f"{prefix}/{mj.body(body).name or f'body_{body}'}"


def shapes(mj: mujoco.MjModel, prefix: str = "robot") -> Iterator[tuple[str, rr.AsComponents]]:
    """Entity and shape of each visible geom type of each body; poses are in the body's frame."""
    visible = (mj.geom_group <= LARGEST_VISUAL_GROUP) & (_colours(mj)[:, 3] > 0)
    for body in range(mj.nbody):
        for kind in np.unique(mj.geom_type[(mj.geom_bodyid == body) & visible]):
            geoms = np.flatnonzero((mj.geom_bodyid == body) & (mj.geom_type == kind) & visible)
            name = mjtGeom(kind).name.removeprefix("mjGEOM_").lower()
            if kind == mjtGeom.mjGEOM_MESH:
                for g in geoms:
                    yield f"{body_entity(mj, body, prefix)}/mesh_{g}", _mesh(mj, int(g))
            elif (shape := _primitive(mj, mjtGeom(kind), geoms)) is not None:
                yield f"{body_entity(mj, body, prefix)}/{name}", shape


def _colours(mj: mujoco.MjModel) -> np.ndarray:
    """Colours (ngeom, 4), 0..255; a material's colour overrides the geom's own."""
    rgba, material = mj.geom_rgba.copy(), mj.geom_matid
    rgba[material >= 0] = mj.mat_rgba[material[material >= 0]]
    return np.rint(255 * rgba).astype(np.uint8)


def _primitive(mj: mujoco.MjModel, kind: mjtGeom, geoms: np.ndarray) -> rr.AsComponents | None:
    """Batch of shapes; kinds that Rerun cannot draw are left out."""
    size, centre, lengths = mj.geom_size[geoms], mj.geom_pos[geoms], 2 * mj.geom_size[geoms, 1]
    common: dict[str, Any] = {
        "quaternions": np.roll(mj.geom_quat[geoms], -1, axis=1),  # Rerun has w last
        "colors": _colours(mj)[geoms],
        "fill_mode": "solid",
    }
    match kind:
        case mjtGeom.mjGEOM_BOX:
            return rr.Boxes3D(centers=centre, half_sizes=size, **common)
        case mjtGeom.mjGEOM_PLANE:
            half = np.where(size[:, :2] > 0.0, size[:, :2], FLOOR)
            flat = np.column_stack([half, np.full(len(half), 1e-3)])
            return rr.Boxes3D(centers=centre - [0.0, 0.0, 2e-3], half_sizes=flat, **common)
        case mjtGeom.mjGEOM_SPHERE | mjtGeom.mjGEOM_ELLIPSOID:
            half = size[:, [0, 0, 0]] if kind == mjtGeom.mjGEOM_SPHERE else size
            return rr.Ellipsoids3D(centers=centre, half_sizes=half, **common)
        case mjtGeom.mjGEOM_CYLINDER:
            return rr.Cylinders3D(centers=centre, lengths=lengths, radii=size[:, 0], **common)
        case mjtGeom.mjGEOM_CAPSULE:
            # A capsule of Rerun starts at its origin, one of MuJoCo is centred there.
            w, x, y, z = mj.geom_quat[geoms].T
            axis = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
            start = centre - size[:, 1:2] * np.column_stack(axis)
            return rr.Capsules3D(translations=start, lengths=lengths, radii=size[:, 0], **common)
    return None


def _mesh(mj: mujoco.MjModel, geom: int) -> rr.Mesh3D:
    mesh, R = int(mj.geom_dataid[geom]), np.empty(9)
    vertices = mj.mesh_vert[mj.mesh_vertadr[mesh] :][: mj.mesh_vertnum[mesh]]
    faces = mj.mesh_face[mj.mesh_faceadr[mesh] :][: mj.mesh_facenum[mesh]]
    mujoco.mju_quat2Mat(R, mj.geom_quat[geom])
    placed = vertices @ R.reshape(3, 3).T + mj.geom_pos[geom]
    colour = _colours(mj)[geom]
    return rr.Mesh3D(vertex_positions=placed, triangle_indices=faces, albedo_factor=colour)
