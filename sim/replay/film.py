"""Pictures and films of a run: the robot as MuJoCo draws it, beside the magnified tool path."""

import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from armside.arrays import Array

from ..records.atomic import atomic
from ..records.files import InputError
from ..records.signals import RecordedRun
from ..records.stored_run import StoredRun
from ..robot_file.find import find_cell
from .entities import BLUE, GREY, INK, ORANGE
from .offscreen import Offscreen, drawn_model, named_camera, widen
from .paths import Contour, fitting_magnification
from .run_scene import REDRAWN, stored_scene

WIDTH, HEIGHT = 800, 600
"""Size of the robot's picture [pixels]; the path's is as high and square."""
RATE = 12.5
"""Frame rate of a film [Hz]."""
FINER = 3
"""Lines are drawn as many times larger, as short ones are rounded to pixels."""
PALE = [245, 190, 130]
PILLOW_FORMATS = {".gif": "GIF", ".webp": "WEBP"}
Line = tuple[Contour, Array | float, Sequence[int] | None, int]
"""Contour, deviation across it [m], colour (None: by the tool's deviation), width [pixels]."""


@dataclass(frozen=True)
class Shots:
    """Runs of one experiment to be drawn."""

    name: str
    """Of its folder."""
    mj: mujoco.MjModel
    runs: Sequence[RecordedRun]
    contours: Sequence[Contour]
    """Path of each run; empty for runs that cut none."""


def stored_shots(run: StoredRun) -> Shots:
    """Shots of a laser, cut or IMU run on disk, or InputError for another one."""
    if run.experiment not in (*REDRAWN, "imu"):
        raise InputError(f"{run.folder} is a run of {run.experiment}, which moves no robot to draw")
    contours = stored_scene(run).contours if run.experiment in REDRAWN else []
    config = run.summary["config"]
    source = Path(config.get("model") or find_cell(config["robot"]).xml)
    mj = drawn_model(run.robot, source, run.file("robot.xml"))
    return Shots(run.folder.name, mj, run.signals.runs, contours)


def picture(file: Path, shown: Sequence[Shots], factor: float | None = None) -> None:
    """Write one picture: the robot at its start, the tool's first and last path beside it.

    Several runs stand below each other. factor: magnification, by default one that fits all.
    """
    cut = [shots.contours for shots in shown if shots.contours]
    if factor is None and cut:
        factor = min(map(fitting_magnification, cut))
    rows = [_row(shots, factor, shots.name if len(shown) > 1 else "") for shots in shown]
    image = Image.new("RGB", (max(row.width for row in rows), HEIGHT * len(rows)), "white")
    for i, row in enumerate(rows):
        image.paste(row, (0, i * HEIGHT))
    with atomic(file) as partial:
        image.save(partial, format="PNG", optimize=True)


def _row(shots: Shots, factor: float | None, name: str) -> Image.Image:
    with Offscreen(shots.mj, WIDTH, HEIGHT) as camera:
        image = _robot(camera, shots.runs[0].recording.truth.qpos[0])
    if name:
        pen = ImageDraw.Draw(image)
        pen.text((20, 14), name, fill=tuple(INK), font=ImageFont.load_default(size=22))
    if not shots.contours:
        return image
    first, last = shots.contours[0], shots.contours[-1]
    title, lines = f"k = {shots.runs[-1].k}", _lines(last, 3)
    if not last.is_part:
        title = f"k = {shots.runs[0].k} thin, {title} thick"
        lines = [(first, first.tool, PALE, 2), *lines]
    return _beside(image, _Panel(shots.contours, factor).draw(title, lines))


def _lines(cut: Contour, motors: int) -> list[Line]:
    """Of motors, as wide as given, and tool; of a part the tool's alone, by its deviation."""
    if cut.is_part:
        return [(cut, cut.tool, None, 4)]
    return [(cut, cut.motor, BLUE, motors), (cut, cut.tool, ORANGE, 3)]


def film(file: Path, shots: Shots, factor: float | None, drawn: Callable[[], None]) -> None:
    """Write all runs in real time: GIF or WebP by Pillow, other kinds by the program ffmpeg."""
    images = _images(shots, factor, drawn)
    with atomic(file) as partial:
        if kind := PILLOW_FORMATS.get(file.suffix.lower()):
            timing = {"duration": round(1e3 / RATE), "loop": 0, "quality": 75}
            next(images).save(partial, kind, save_all=True, append_images=images, **timing)
        else:
            _by_ffmpeg(partial, file.suffix, images)


def n_images(shots: Shots) -> int:
    """Number of pictures in a film of the runs."""
    return sum(len(_times(run)) for run in shots.runs)


def check_film(file: Path) -> None:
    """Raise InputError for a kind of film that cannot be written here."""
    kind = file.suffix.lower()
    if kind not in (*PILLOW_FORMATS, ".mp4", ".webm", ".mkv"):
        raise InputError(f"{file.name}: a film ends with .gif, .webp, .mp4, .webm or .mkv")
    if kind not in PILLOW_FORMATS and shutil.which("ffmpeg") is None:
        raise InputError(f"{file.name} needs the program ffmpeg; .gif and .webp do without")


def _times(run: RecordedRun) -> Array:
    return np.arange(0.0, run.recording.time[-1], 1.0 / RATE)


def _images(shots: Shots, factor: float | None, drawn: Callable[[], None]) -> Iterator[Image.Image]:
    panel = _Panel(shots.contours, factor) if shots.contours else None
    with Offscreen(shots.mj, WIDTH, HEIGHT) as camera:
        for i, run in enumerate(shots.runs):
            truth = run.recording.truth
            for time in _times(run).tolist():
                row = min(int(np.searchsorted(truth.time, time)), len(truth.time) - 1)
                image = _robot(camera, truth.qpos[row])
                if panel is not None:
                    lines = _lines(shots.contours[i], 2)
                    image = _beside(image, panel.draw(f"k = {run.k}", lines, until=time))
                yield image
                drawn()


def _robot(camera: Offscreen, qpos: Array) -> Image.Image:
    data = mujoco.MjData(camera.mj)
    data.qpos[:] = qpos
    mujoco.mj_forward(camera.mj, data)
    view = named_camera(camera.mj, "whole")
    widen(camera.mj, data, view, WIDTH / HEIGHT)
    return Image.fromarray(camera.draw(data, view))


def _beside(robot: Image.Image, panel: Image.Image) -> Image.Image:
    image = Image.new("RGB", (robot.width + panel.width, robot.height), "white")
    image.paste(robot, (0, 0))
    image.paste(panel, (robot.width, 0))
    return image


class _Panel:
    """Tool paths in the plane of the cut, y up, with the magnification that fits all contours."""

    def __init__(self, contours: Sequence[Contour], factor: float | None) -> None:
        self.programmed: Line = (contours[0], 0.0, GREY, 2)
        self.factor = factor or fitting_magnification(contours)
        room = 2.6 if contours[0].is_part else 4.4  # of magnified deviations
        self.scale = HEIGHT / (contours[0].half_size * 1e3 * room)  # pixels a millimetre

    def draw(self, title: str, lines: Sequence[Line], until: float = np.inf) -> Image.Image:
        """Picture of the programmed path and of lines up to the time `until` [s]."""
        image = Image.new("RGB", (FINER * HEIGHT, FINER * HEIGHT), "white")
        self._line(pen := ImageDraw.Draw(image), self.programmed, np.inf)
        for line in lines:
            self._line(pen, line, until)
        image = image.reduce(FINER)
        pen, ink = ImageDraw.Draw(image), tuple(INK)
        pen.text((20, 14), title, fill=ink, font=ImageFont.load_default(size=22))
        times = f"deviation magnified {self.factor:g} times"
        legend = f"grey programmed, blue motors, orange tool; {times}"
        if (part := lines[-1][0]).is_part:
            worst = f"{1e3 * part.worst:.2f} mm"
            legend = f"tool: blue -{worst}, grey 0, red {worst} beside the contour"
        pen.text((20, HEIGHT - 34), legend, fill=ink, font=ImageFont.load_default(size=17))
        return image

    def _line(self, pen: ImageDraw.ImageDraw, line: Line, until: float) -> None:
        contour, deviation, colour, width = line
        done = int(np.searchsorted(contour.time, until, side="right"))
        if colour is None:
            pieces, colours = contour.coloured(self.factor)
            for piece, own in zip(pieces[: contour.cutting[:done].sum()], colours, strict=False):
                middle, r = self._pixels(piece.mean(axis=0)), FINER * width / 2
                box = (*(middle - r).tolist(), *(middle + r).tolist())
                pen.ellipse(box, fill=tuple(own.tolist()))  # a line of few pixels is not as wide
            return
        points = contour.magnified(deviation, self.factor)
        for piece in contour.pieces:
            at = self._pixels(points[piece.start : min(piece.stop, done)]).tolist()
            if len(at) > 1:
                pen.line(
                    list(map(tuple, at)), fill=tuple(colour), width=FINER * width, joint="curve"
                )

    def _pixels(self, points: Array) -> Array:
        return FINER * (points * self.scale + HEIGHT / 2)


def _by_ffmpeg(file: Path, suffix: str, images: Iterator[Image.Image]) -> None:
    first = next(images)
    size = f"{first.width}x{first.height}"
    command = ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", size, "-r", f"{RATE:g}", "-i", "-", "-pix_fmt", "yuv420p"]
    command += ["-f", {".mkv": "matroska"}.get(suffix.lower(), suffix[1:].lower()), str(file)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:
        assert process.stdin is not None
        for image in (first, *images):
            process.stdin.write(image.tobytes())
        process.stdin.close()
        if process.wait():
            raise OSError("ffmpeg failed")
