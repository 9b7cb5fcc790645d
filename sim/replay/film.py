"""Pictures and films of a run: the robot as MuJoCo draws it, beside the magnified tool path."""

import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from ..cell import CELLS
from ..records.atomic import atomic
from ..records.errors import InputError
from ..records.signals import RecordedRun
from ..records.stored_run import StoredRun
from .entities import BLUE, GREY, ORANGE
from .offscreen import Offscreen, drawn_model, named_camera
from .paths import Contour, fitting_magnification
from .run_scene import stored_scene

WIDTH, HEIGHT = 800, 600
"""Size of the robot's picture [pixels]; the path's is as high and square."""
RATE = 12.5
"""Frame rate of a film [Hz]."""
INK = (60, 60, 60)
PILLOW_FORMATS = {".gif": "GIF", ".webp": "WEBP"}


@dataclass(frozen=True)
class Shot:
    """One run to be drawn, and its path, if it cuts one."""

    run: RecordedRun
    contour: Contour | None


def stored_shots(run: StoredRun) -> tuple[mujoco.MjModel, list[Shot]]:
    """Robot and shots of a laser or an IMU run on disk.

    Raises:
        InputError: another experiment, or a run that lacks its path or its robot.
    """
    if run.experiment not in ("laser", "imu"):
        raise InputError(f"{run.folder} is a run of {run.experiment}, which moves no robot to draw")
    if run.experiment == "laser":
        scene = stored_scene(run)
        taken = [Shot(*each) for each in zip(scene.runs, scene.contours, strict=True)]
    else:
        taken = [Shot(each, None) for each in run.signals.runs]
    config = run.summary["config"]
    source = Path(config.get("model") or CELLS[config["robot"]].xml)
    return drawn_model(run.robot, source, run.file("robot.xml")), taken


def picture(file: Path, mj: mujoco.MjModel, taken: Sequence[Shot], factor: float | None) -> None:
    """One picture: the robot as it starts to cut, the tool's first and last path beside it."""
    with Offscreen(mj, WIDTH, HEIGHT) as camera:
        robot = _robot(camera, taken[0].run.recording.truth.qpos[0])
    panel = _Panel(taken, factor)
    image = _beside(robot, panel.first_and_last() if panel.shown else None)
    with atomic(file) as partial:
        image.save(partial, format="PNG", optimize=True)


def film(
    file: Path,
    mj: mujoco.MjModel,
    taken: Sequence[Shot],
    factor: float | None,
    drawn: Callable[[], None],
) -> None:
    """All runs, in real time: GIF or WebP by Pillow, other kinds by the program ffmpeg."""
    images = _images(mj, taken, factor, drawn)
    with atomic(file) as partial:
        if kind := PILLOW_FORMATS.get(file.suffix.lower()):
            first = next(images)
            first.save(
                partial,
                format=kind,
                save_all=True,
                append_images=images,
                duration=round(1e3 / RATE),
                loop=0,
                quality=75,
            )
        else:
            _by_ffmpeg(partial, file.suffix, images)


def n_images(taken: Sequence[Shot]) -> int:
    """Number of pictures in a film of the runs."""
    return sum(len(_times(shot.run)) for shot in taken)


def check_film(file: Path) -> None:
    """Raise InputError for a kind of film that cannot be written here."""
    if file.suffix.lower() in PILLOW_FORMATS:
        return
    if file.suffix.lower() not in (".mp4", ".webm", ".mkv"):
        raise InputError(f"{file.name}: a film ends with .gif, .webp, .mp4, .webm or .mkv")
    if shutil.which("ffmpeg") is None:
        raise InputError(f"{file.name} needs the program ffmpeg; .gif and .webp do without")


def _times(run: RecordedRun) -> NDArray[np.float64]:
    return np.arange(0.0, run.recording.time[-1], 1.0 / RATE)


def _images(
    mj: mujoco.MjModel, taken: Sequence[Shot], factor: float | None, drawn: Callable[[], None]
) -> Iterator[Image.Image]:
    panel = _Panel(taken, factor)
    with Offscreen(mj, WIDTH, HEIGHT) as camera:
        for shot in taken:
            truth = shot.run.recording.truth
            for time in _times(shot.run):
                row = min(int(np.searchsorted(truth.time, time)), len(truth.time) - 1)
                robot = _robot(camera, truth.qpos[row])
                yield _beside(robot, panel.at(shot, float(time)) if panel.shown else None)
                drawn()


def _robot(camera: Offscreen, qpos: NDArray[np.float64]) -> Image.Image:
    data = mujoco.MjData(camera.mj)
    data.qpos[:] = qpos
    mujoco.mj_forward(camera.mj, data)
    return Image.fromarray(camera.draw(data, named_camera(camera.mj, "whole")))


def _beside(robot: Image.Image, panel: Image.Image | None) -> Image.Image:
    if panel is None:
        return robot
    image = Image.new("RGB", (robot.width + panel.width, robot.height), "white")
    image.paste(robot, (0, 0))
    image.paste(panel, (robot.width, 0))
    return image


class _Panel:
    """Tool paths in the plane of the cut, y up."""

    def __init__(self, taken: Sequence[Shot], factor: float | None) -> None:
        self.taken = taken
        contours = [shot.contour for shot in taken if shot.contour is not None]
        self.shown = len(contours) == len(taken)
        if self.shown:
            self.factor = factor or fitting_magnification(contours)
            self.scale = HEIGHT / (contours[0].half_size * 1e3 * 4.4)  # pixels a millimetre

    def first_and_last(self) -> Image.Image:
        first, last = self.taken[0], self.taken[-1]
        image, draw = self._empty(f"k = {first.run.k} thin, k = {last.run.k} thick")
        self._line(draw, first.contour, "tool", (245, 190, 130), 2)
        self._line(draw, last.contour, "motor", tuple(BLUE), 3)
        self._line(draw, last.contour, "tool", tuple(ORANGE), 3)
        return image

    def at(self, shot: Shot, time: float) -> Image.Image:
        image, draw = self._empty(f"k = {shot.run.k}")
        self._line(draw, shot.contour, "motor", tuple(BLUE), 2, until=time)
        self._line(draw, shot.contour, "tool", tuple(ORANGE), 3, until=time)
        return image

    def _empty(self, title: str) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        image = Image.new("RGB", (HEIGHT, HEIGHT), "white")
        draw = ImageDraw.Draw(image)
        font = ImageFont.load_default(size=22)
        draw.text((20, 14), title, fill=INK, font=font)
        small = ImageFont.load_default(size=17)
        legend = f"grey programmed, blue motors, orange tool; deviation {self.factor:g} times"
        draw.text((20, HEIGHT - 34), legend, fill=INK, font=small)
        self._line(draw, self.taken[0].contour, "programmed", tuple(GREY), 2)
        return image, draw

    def _line(
        self,
        draw: ImageDraw.ImageDraw,
        contour: Contour | None,
        what: str,
        colour: tuple[int, ...],
        width: int,
        until: float = np.inf,
    ) -> None:
        assert contour is not None
        zero = np.zeros(len(contour.time))
        deviation = {"motor": contour.motor, "tool": contour.tool}.get(what, zero)
        points = contour.magnified(deviation, self.factor)
        shown = points[contour.cutting & (contour.time <= until)]
        if len(shown) > 1:
            place = shown * self.scale + HEIGHT / 2
            draw.line([(float(x), float(y)) for x, y in place], fill=colour, width=width)


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
