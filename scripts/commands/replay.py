"""`armside replay`: watch a run: the robot, the tool's path magnified, motor beside arm side."""

import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from armside.sim.records.stored_run import StoredRun, read_run
from armside.sim.records.summary import summary

from ..shell.console import Report, keep
from ..shell.display import check_display
from ..shell.errors import InputError, RunFailed, checking_input
from ..shell.options import Common, options


@options
@dataclass(frozen=True, kw_only=True)
class ReplayCfg:
    """Where to show it and how."""

    web: bool = False
    """In a browser: serve Rerun's web viewer to this machine only, until Ctrl-C."""
    port: int = 9090
    """Where the web viewer is served; 0 takes any free port."""
    save: Path | None = None
    """Write the replay to this file (.rrd) instead of showing it."""
    png: Path | None = None
    """Write a picture of robot and tool path to this file (.png), without a window."""
    video: Path | None = None
    """Write a film of the runs to this file (.gif, .webp; .mp4 with ffmpeg), without a window."""
    magnification: float | None = None
    """Of deviations from the path [default: 50, or less if the drawing would not fit]."""
    telemetry: bool = False
    """Let the viewer send usage statistics to its makers, as their settings say."""

    def __post_init__(self) -> None:
        if self.magnification is not None and not (
            np.isfinite(self.magnification) and self.magnification > 0.0
        ):
            raise ValueError(f"magnification must be > 0, got {self.magnification:g}")
        if not 0 <= self.port <= 65535:
            raise ValueError(f"port must be in [0, 65535], got {self.port}")
        for name, suffix in (("save", ".rrd"), ("png", ".png")):
            file = getattr(self, name)
            if file is not None and file.suffix.lower() != suffix:
                raise ValueError(f"{name} takes a file that ends with {suffix}, got {file.name}")
        for name in ("save", "png", "video"):
            _check_place(getattr(self, name))

    @property
    def shows(self) -> bool:
        """Whether a viewer is wanted, rather than files alone."""
        return self.web or (self.save is None and self.png is None and self.video is None)


def _check_place(file: Path | None) -> None:
    if file is not None and not file.absolute().parent.is_dir():
        raise ValueError(f"{file.parent} is no folder")
    if file is not None and file.is_dir():
        raise ValueError(f"{file} is a folder")


def replay(
    *runs: Annotated[Path, Parameter(help="Folders of runs; several are shown side by side.")],
    cfg: ReplayCfg = ReplayCfg(),
    common: Common = Common(),
) -> None:
    """Watch runs in the Rerun viewer, or write a replay, a picture or a film of them."""
    report = Report(common)
    stored = _opened(runs, cfg)
    written: list[Path] = []
    if cfg.save is not None or cfg.shows:
        with _replay_file(cfg.save, stored, cfg.magnification) as file:
            if cfg.save is not None:
                written.append(cfg.save)
                report.line(f"Replay in {cfg.save}")
            if cfg.web:
                _serve(file, cfg, report)
            elif cfg.shows:
                _show(file, cfg)
    if cfg.png is not None or cfg.video is not None:
        written += _draw(stored[0], cfg, report)
    outcome = summary("replay", cfg, common, runs=list(runs), written=written)
    keep(outcome, common)
    report.summary(outcome)


def _opened(runs: Sequence[Path], cfg: ReplayCfg) -> list[StoredRun]:
    """Everything that can be refused, before anything is written or shown."""
    if not runs:
        raise InputError(
            "give the folder of a run, such as runs/laser-...; `armside laser` makes one"
        )
    if len({run.resolve() for run in runs}) < len(runs):
        raise InputError("a folder was given twice")
    stored = [read_run(run) for run in runs]
    if len(stored) > 1 and (other := [r for r in stored if r.experiment != "laser"]):
        raise InputError(f"only laser runs are shown side by side; {other[0].path} is another")
    if cfg.video is not None:
        from armside.sim.replay.film import check_film

        check_film(cfg.video)
    if len(stored) > 1 and (cfg.png or cfg.video):
        raise InputError("--png and --video take one run")
    if stored[0].experiment != "laser" and cfg.magnification is not None:
        raise InputError("--magnification is for laser runs: others have no path to deviate from")
    if cfg.shows and not cfg.web:
        check_display("use --web for a browser, or --save, --png, --video for files")
    return stored


@contextmanager
def _replay_file(
    save: Path | None, stored: Sequence[StoredRun], magnification: float | None
) -> Iterator[Path]:
    """The replay of the runs, in the file asked for or one that goes away."""
    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        file = save or Path(folder) / "replay.rrd"
        if stored[0].experiment == "laser":
            _write_laser(file, stored, magnification)
        else:
            _copy(stored[0], file)
        yield file


def _write_laser(file: Path, stored: Sequence[StoredRun], magnification: float | None) -> None:
    from armside.sim.replay.scene import write_scenes

    from ..viewers.stored_scene import stored_scene

    names = _names([run.path for run in stored]) if len(stored) > 1 else [""]
    scenes = [stored_scene(run, name=name) for run, name in zip(stored, names, strict=True)]
    write_scenes(file, scenes, magnification=magnification)


def _names(paths: Sequence[Path]) -> list[str]:
    """The folders' own names; numbered where two are alike."""
    names = [path.resolve().name for path in paths]
    return [name if names.count(name) == 1 else f"{name}-{i + 1}" for i, name in enumerate(names)]


def _copy(run: StoredRun, file: Path) -> None:
    own = run.path / "replay.rrd"
    if not own.is_file():
        raise InputError(f"{run.path} has no replay: `{run.experiment}` writes none")
    from armside.sim.records.atomic import atomic

    with atomic(file) as partial:
        partial.write_bytes(own.read_bytes())


def _serve(file: Path, cfg: ReplayCfg, report: Report) -> None:
    """Until Ctrl-C, which is the way to end it."""
    from ..viewers.web_viewer import WebViewer

    viewer = WebViewer(file, port=cfg.port, telemetry=cfg.telemetry)
    # Also where a shell started us in the background and had us ignore Ctrl-C.
    before = {
        ending: signal.signal(ending, signal.default_int_handler)
        for ending in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        report.line(f"Open {viewer.address} in a browser on this machine; Ctrl-C ends")
        sys.stdout.flush()
        viewer.serve()
    except KeyboardInterrupt:
        report.line("ended")
    finally:
        for ending, handler in before.items():
            signal.signal(ending, handler)


def _show(file: Path, cfg: ReplayCfg) -> None:
    """The native viewer, until its window is closed."""
    from ..viewers.web_viewer import LOOPBACK, private_environment, rerun_program

    command = [rerun_program(), str(file), "--bind", LOOPBACK, "--port", "auto"]
    with private_environment(cfg.telemetry) as env:
        try:
            status = subprocess.run(command, env=env, check=False).returncode
        except KeyboardInterrupt:
            return
    if status:
        raise RunFailed(f"the viewer ended with status {status}; --web shows it in a browser")


def _draw(run: StoredRun, cfg: ReplayCfg, report: Report) -> list[Path]:
    """Picture and film; returns what was written."""
    from armside.sim.replay import film
    from armside.sim.replay.offscreen import NoGraphicsError, drawn_model

    with checking_input():
        mj, source, taken = _shots(run)
    drawn = drawn_model(mj, source)
    try:
        if cfg.png is not None:
            film.picture(cfg.png, drawn, taken, cfg.magnification)
            report.line(f"Picture in {cfg.png}")
        if cfg.video is not None:
            with report.progress("drawing", total=film.n_images(taken)) as step:
                film.film(cfg.video, drawn, taken, cfg.magnification, step)
            report.line(f"Film in {cfg.video}")
    except NoGraphicsError as error:
        raise InputError(f"cannot draw without a window: {error}") from error
    return [file for file in (cfg.png, cfg.video) if file is not None]


def _shots(run: StoredRun):
    """(model, its file, what is to be drawn) of a laser or an IMU run."""
    from armside.sim.cell import CELLS
    from armside.sim.replay.film import Shot, shots

    config = run.summary["config"]
    if run.experiment == "laser":
        from ..viewers.stored_scene import stored_scene

        scene = stored_scene(run)
        source = Path(config["model"]) if config.get("model") else CELLS[config["robot"]].xml
        return scene.mj, source, shots(scene)
    if run.experiment == "imu":
        from .imu import ImuOptions

        model = run.configuration(ImuOptions).experiment().model()
        runs = run.signals.runs
        return model.mj, CELLS[config["robot"]].xml, [Shot(one, None) for one in runs]
    raise InputError(f"{run.path} is a run of {run.experiment}, which moves no robot to be drawn")
