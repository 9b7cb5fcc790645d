"""`armside gallery`: the pictures of the docs, made again from seeds."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from armside.sim.records.run_folder import check_shared_folder
from armside.sim.records.summary import summary

from ..figures.gallery import PICTURES, shrink
from ..shell.console import Report, keep
from ..shell.errors import checking_input, unknown
from ..shell.options import Common, Folder, options

IMAGES = Path("docs") / "images"


@options
@dataclass(frozen=True, kw_only=True)
class GalleryCfg:
    """Destination of the pictures."""

    images: Folder = IMAGES
    """Folder to write to."""


def gallery(
    *names: Annotated[str, Parameter(help="Which pictures [default: all].")],
    cfg: GalleryCfg = GalleryCfg(),
    common: Common = Common(),
) -> None:
    """Make the pictures of the docs again: runs, robots, the replay in a browser.

    `replay` needs Chromium and its driver; `robots` and `picture` need OpenGL (EGL).
    """
    from .laser import laser

    report = Report(common)
    for name in names:
        if name not in PICTURES:
            raise unknown("picture", name, PICTURES)
    chosen = list(names or PICTURES)
    with checking_input():
        check_shared_folder(cfg.images)
    made, drawing = dict[str, int](), report.progress("drawing", total=len(chosen))
    with tempfile.TemporaryDirectory(prefix="armside-") as folder, drawing as step:
        run = Path(folder) / "run"
        laser(common=Common(seed=common.seed, out=run, quiet=True))
        for name in chosen:
            raw = Path(folder) / f"{name}.png"
            PICTURES[name](run, raw)
            cfg.images.mkdir(parents=True, exist_ok=True)
            made[name] = shrink(raw, cfg.images / f"{name}.png")
            step()
    sizes = [(name, size // 1000) for name, size in made.items()]
    report.table(f"Pictures in {cfg.images}", ["name", "kB"], sizes)
    outcome = summary("gallery", cfg, common, bytes=made)
    keep(outcome, common)
    report.summary(outcome)
