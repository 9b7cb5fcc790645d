"""`armside calibrate`: the unknown numbers of the large robot, from its targets of chapter 9."""

from dataclasses import dataclass, fields
from pathlib import Path

from armside import assets
from armside.sim.calibration.parameters import differing, rewrite
from armside.sim.calibration.search import START, checks, evaluate, score, search
from armside.sim.cell import LARGE_CELL
from armside.sim.records.atomic import write_whole
from armside.sim.records.files import check_file
from armside.sim.records.summary import summary
from armside.sim.robot.kinematics_check import cell_model

from ..jobs.workers import Workers
from ..shell.console import Report, keep
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import RunFailed, checking_input
from ..shell.options import Common, options

OF_A_GENERATION = Effort(20.0)


@options
@dataclass(frozen=True, kw_only=True)
class CalibrateCfg:
    """Length of the search, and use of its result."""

    generations: int = 12
    """Generations of four candidates; 0 checks the numbers in the file and searches nothing."""
    file: Path = assets.LARGE_ROBOT_XML
    """MJCF that the numbers are compared with."""
    write: bool = False
    """Write the numbers found into that file."""

    def __post_init__(self) -> None:
        if self.generations < 0:
            raise ValueError(f"generations must be >= 0, got {self.generations}")


def calibrate(*, cfg: CalibrateCfg = CalibrateCfg(), common: Common = Common()) -> None:
    """Calibrate the large robot to the phenomena of thesis chapter 9, and compare with its file.

    The search is the same for the same seed, whatever the number of cores. With --generations 0
    the numbers in the file are held against the targets.
    """
    report = Report(common)
    refuse_absurd(f"{cfg.generations} generations", OF_A_GENERATION * cfg.generations)
    with checking_input():
        check_file(cfg.file)
        present = cell_model(LARGE_CELL, cfg.file)
    trim, differs = None, []
    if cfg.generations == 0:
        found, said = checks(present)
    else:
        best = evaluate(START)
        with Workers() as workers, report.progress("calibrating", cfg.generations) as step:
            for candidate in search(START, cfg.generations, common.seed, workers.map):
                best = candidate
                step()
        found, said, trim = best.checks, best.notes, best.trim
    rows: list[tuple[str | float, ...]] = []
    for c in found:
        band = ["" if end is None else f"{end:g}" for end in (c.low, c.high)]
        rows.append((f"{c.id}: {c.statement}", c.ours, *band, "yes" if c.holds else "NO"))
    report.notes(said)
    report.table("Targets", ("number", "value", "from", "to", "holds"), rows)
    if trim is not None:
        values = [(f.name, str(getattr(trim, f.name))) for f in fields(trim)]
        report.table("Found", ("quantity", "value"), values)
        differs = differing(cfg.file, trim)
        if cfg.write:
            write_whole(cfg.file, rewrite(cfg.file.read_text(encoding="utf-8"), trim))
    result = {"score": score(found), "trim": trim, "findings": rows, "notes": said}
    outcome = summary("calibrate", cfg, common, **result)
    keep(outcome, common)
    report.summary(outcome)
    failed = [check.statement for check in found if not check.holds]
    if failed:
        raise RunFailed(f"{len(failed)} of {len(found)} targets are missed: {', '.join(failed)}")
    if differs and not cfg.write:
        raise RunFailed(f"{cfg.file} has other numbers: {', '.join(differs)}")
