"""`armside replay`: robot, magnified tool path, motor and arm side of a run."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from armside.sim.records import StoredRun, read_run
from armside.sim.records.summary import summary

from ..shell.console import Report
from ..shell.errors import InputError, checking_input
from ..shell.options import Common, FileToWrite, options
from ..viewers.web_viewer import check_display, serve, show

if TYPE_CHECKING:
    from armside.sim.replay.film import Shots


@options
@dataclass(frozen=True, kw_only=True)
class ReplayCfg:
    """Viewer or files, and magnification."""

    web: bool = False
    """In a browser: serve Rerun's web viewer to this machine only, until Ctrl-C."""
    port: Annotated[int, Parameter(validator=Number(gte=0, lte=65535))] = 9090
    """Port of the web viewer; 0 takes any free one."""
    save: FileToWrite = None
    """Write the replay to this file (.rrd) instead of showing it."""
    png: FileToWrite = None
    """Write a picture of robot and tool path to this file (.png), without a window; several runs
    below each other."""
    video: FileToWrite = None
    """Write a film of the runs to this file (.gif, .webp; .mp4 with ffmpeg), without a window."""
    magnification: Annotated[float | None, Parameter(validator=Number(gt=0))] = None
    """Factor on deviations from the path [default: 50, or less if the drawing would not fit]."""
    telemetry: bool = False
    """Let the viewer send usage statistics to its makers, as their settings say."""

    def __post_init__(self) -> None:
        for name, suffix in (("save", ".rrd"), ("png", ".png"), ("video", "")):
            if (file := getattr(self, name)) is None:
                continue
            if suffix and file.suffix.lower() != suffix:
                raise ValueError(f"{name} takes a file that ends with {suffix}, got {file.name}")


Runs = Annotated[Path, Parameter(help="Folders of runs; several are shown side by side.")]


def replay(*runs: Runs, cfg: ReplayCfg = ReplayCfg(), common: Common = Common()) -> None:
    """Watch runs in the Rerun viewer, or write a replay, a picture or a film of them."""
    report = Report(common)
    with checking_input():
        stored = _opened(runs, cfg)
        shots: list[Shots] = []
        if cfg.png is not None or cfg.video is not None:
            from armside.sim.replay import film

            shots = [film.stored_shots(run) for run in stored]
    written = [file for file in (cfg.save, cfg.png, cfg.video) if file is not None]
    if cfg.web or cfg.save is not None or not written:
        _write_and_show(stored, cfg, report)
    if shots:
        from armside.sim.replay import film

        if cfg.png is not None:
            film.picture(cfg.png, shots, cfg.magnification)
            report.line(f"Picture in {cfg.png}")
        if cfg.video is not None:
            with report.progress("drawing", total=film.n_images(shots[0])) as step:
                film.film(cfg.video, shots[0], cfg.magnification, step)
            report.line(f"Film in {cfg.video}")
    outcome = summary("replay", cfg, common, runs=list(runs), written=written)
    report.kept(outcome)


def _opened(runs: tuple[Path, ...], cfg: ReplayCfg) -> list[StoredRun]:
    """Runs of the folders, with all input checked before anything is written or shown."""
    if not runs:
        raise InputError(
            "give the folder of a run, such as runs/laser-...; `armside laser` makes one"
        )
    if len({run.resolve() for run in runs}) < len(runs):
        raise InputError("a folder was given twice")
    stored = [read_run(run) for run in runs]
    others = [run for run in stored if run.experiment not in ("laser", "cut")]
    if len(stored) > 1 and others:
        raise InputError(
            f"only runs of laser and cut are shown side by side; {others[0].folder} is another"
        )
    if cfg.video is not None:
        from armside.sim.replay.film import check_film

        check_film(cfg.video)
    if len(stored) > 1 and cfg.video:
        raise InputError("--video takes one run")
    if others and cfg.magnification is not None:
        raise InputError(
            "--magnification is for runs of laser and cut: others have no path to deviate from"
        )
    if not (cfg.web or cfg.save or cfg.png or cfg.video):
        check_display("use --web for a browser, or --save, --png, --video for files")
    return stored


def _write_and_show(stored: list[StoredRun], cfg: ReplayCfg, report: Report) -> None:
    from armside.sim.replay.run_scene import read_replay, write_replay

    with checking_input():
        replay = read_replay(stored)
    with tempfile.TemporaryDirectory(prefix="armside-") as folder:
        file = cfg.save or Path(folder) / "replay.rrd"
        write_replay(file, replay, magnification=cfg.magnification)
        if cfg.save is not None:
            report.line(f"Replay in {cfg.save}")
        if cfg.web:
            serve(file, report.line, port=cfg.port, telemetry=cfg.telemetry)
        elif cfg.save is None:
            show(file, cfg.telemetry)
