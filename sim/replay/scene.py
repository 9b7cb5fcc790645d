"""`replay.rrd`: the runs of an experiment for the Rerun viewer, sent as columns.

Two timelines. `time` lays the runs one after the other; `iteration` holds the last state of each,
so its slider compares the paths learned. A file is written; nothing is shown or sent anywhere.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from shutil import copyfileobj
from threading import Thread

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from armside import kinematics
from armside.arrays import Array

from ..motion.tool_motion import ToolMotion
from ..part.motion import PartMotion
from ..records.atomic import atomic
from ..records.signals import RecordedRun
from . import entities
from .blueprint import Layout, blueprint
from .paths import Contour, fitting_magnification

WORST_SHOWN = 3.0
"""Largest error shown by a learning curve, relative to the first run's."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One experiment as a replay shows it."""

    mj: mujoco.MjModel
    """Model of the runs; it has as many joint positions as their qpos."""
    runs: Sequence[RecordedRun]
    """Iterations, in order."""
    motion: ToolMotion | PartMotion
    robot: kinematics.Robot
    """D-H model, which gives the tool's path by motor angles alone."""
    name: str = ""
    """Name of the experiment where several are shown side by side."""
    about: str = ""
    """Markdown: design variables and measures."""
    learning: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """Learning curves by the name of the line: for each run its error relative to the first."""

    def __post_init__(self) -> None:
        if not self.runs:
            raise ValueError("a replay needs at least one run")
        if (nq := self.runs[0].recording.truth.qpos.shape[1]) != self.mj.nq:
            raise ValueError(f"the runs have {nq} joint positions, the model has {self.mj.nq}")
        for name, values in self.learning.items():
            if len(values) != (n := len(self.runs)):
                raise ValueError(f"learning {name!r} has {len(values)} values for {n} runs")

    @property
    def contours(self) -> list[Contour]:
        """Programmed, motor-side and true tool path of each run."""
        compiled = kinematics.compile(self.robot)
        return [Contour(run, self.motion, compiled) for run in self.runs]


def write_scenes(
    path: Path, scenes: Sequence[Scene], *, magnification: float | None = None
) -> None:
    """Write one or more experiments side by side, whole or not at all. Iterations start together.

    magnification: of deviations, by default `fitting_magnification`. Raises ValueError for no
    scene, two of one name, or a magnification that is not above 0.
    """
    names = [scene.name for scene in scenes]
    if not scenes or len(set(names)) != len(names):
        raise ValueError(f"a replay needs experiments of different names, got {names}")
    if magnification is not None and not (np.isfinite(magnification) and magnification > 0.0):
        raise ValueError(f"magnification must be > 0, got {magnification:g}")
    contours = [scene.contours for scene in scenes]
    factor = magnification or min(fitting_magnification(own) for own in contours)
    worst, starts = _worst(scenes), _starts(scenes)
    layouts = [_layout(scene, factor, worst, starts) for scene in scenes]
    with recording(path, blueprint(layouts)) as stream:
        for scene, own, layout in zip(scenes, contours, layouts, strict=True):
            to = entities.Entities(stream, layout)
            entities.send_static(to, scene.mj, own[0], scene.about, scene.robot.n_joints)
            entities.send_paths(to, scene.runs, own, starts)
            entities.send_learning(to, scene.runs, scene.learning, starts)
            for run, contour, start in zip(scene.runs, own, starts.tolist(), strict=False):
                entities.send_bodies(stream, scene.mj, run, start, prefix=layout.entity("robot"))
                entities.send_contour(to, run.k, contour, start)
                entities.send_series(to, run, contour, start)
                entities.send_spectrum(to, run.k, contour, start)


def _starts(scenes: Sequence[Scene]) -> Array:
    """Start of each iteration [s]: after the longest of the one before."""
    ends = [[run.recording.time[-1] for run in scene.runs] for scene in scenes]
    last = np.array([max(at_k) for at_k in zip_longest(*ends, fillvalue=0.0)])
    return np.concatenate([[0.0], np.cumsum(last[:-1] + entities.FRAME_PERIOD)])


def _worst(scenes: Sequence[Scene]) -> float:
    """Upper end of the axis of all learning curves [%], at most 100 WORST_SHOWN."""
    values = np.array([x for scene in scenes for curve in scene.learning.values() for x in curve])
    finite = values[np.isfinite(values)]
    return 100.0 * float(np.clip(finite.max(initial=1.0), 1.0, WORST_SHOWN))


def _layout(scene: Scene, factor: float, worst: float, starts: Array) -> Layout:
    data = mujoco.MjData(scene.mj)
    data.qpos[:] = scene.runs[0].recording.truth.qpos[0]
    mujoco.mj_kinematics(scene.mj, data)
    return Layout(
        name=scene.name,
        factor=factor,
        target=scene.motion.plane.origin,
        height=float(data.geom_xpos[:, 2].max()),
        worst=worst,
        end=float(starts[len(scene.runs) - 1] + scene.runs[-1].recording.time[-1]),
        is_part=isinstance(scene.motion, PartMotion) and len(scene.motion.cuts) > 1,
    )


@contextmanager
def recording(path: Path, blueprint: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """Stream whose content becomes the file when the block ends without an error.

    Raises OSError, such as on a full disk.
    """
    stream = rr.RecordingStream("armside", send_properties=False)
    with atomic(path) as partial, _copied_to(partial) as pipe:
        try:
            # As the default blueprint of the file: one that is sent is not shown by the viewer.
            stream.save(pipe, default_blueprint=blueprint)
            yield stream
            stream.flush()
        finally:
            stream.disconnect()


@contextmanager
def _copied_to(file: Path) -> Iterator[str]:
    """Name of a pipe whose content is written to a file. Rerun's own writer, on a full disk, waits
    for ever or ends the process without an error."""
    source, sink = os.pipe()
    failures: list[OSError] = []
    copying = Thread(target=_copy, args=(source, file, failures))
    copying.start()
    try:
        yield f"/dev/fd/{sink}"
    finally:
        os.close(sink)
        copying.join()
    for failure in failures:
        raise failure


def _copy(source: int, file: Path, failures: list[OSError]) -> None:
    with open(source, "rb") as content:
        try:
            with file.open("wb") as out:
                copyfileobj(content, out)
        except OSError as error:
            failures.append(error)
            while content.read(1 << 20):  # or whoever writes into the pipe would wait
                pass
