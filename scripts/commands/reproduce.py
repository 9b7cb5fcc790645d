"""`armside reproduce`: the figures and numbers of the thesis again, in one report, with verdicts.

A chapter adds a section with one line in ENTRIES: a function `(seed) -> Part` that names the
experiments a section needs and draws it from their results.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, NamedTuple

from cyclopts import Parameter

from armside.sim.records.atomic import write_whole
from armside.sim.records.run_folder import RUNS
from armside.sim.records.summary import dumps, summary

from ..jobs.batch import missing, run_batch
from ..jobs.store import Store
from ..jobs.workers import Workers
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common
from ..shell.registry import load, unknown
from ..thesis.pages import count, html, markdown
from ..thesis.report import MARKER, Part, ReportFolder, Section, as_rows

TITLE = "The thesis made again: an IMU on a robot, learning on a joint and on a robot"
DRAWING = 1.5
"""What drawing a section counts in the progress, beside the cost of jobs."""


class Entry(NamedTuple):
    """One section that can be asked for."""

    id: str
    also: tuple[str, ...]
    """Other names: rows of the map, equations."""
    chapter: str
    """A chapter makes all of its own; empty: only made by name, since it takes minutes."""
    part: str
    """module:function of the Part."""


ENTRIES = (
    Entry("5.2", ("E02",), "5", "armside.scripts.thesis.chapter5:rest"),
    Entry("5.3", ("E01",), "5", "armside.scripts.thesis.chapter5:mounting"),
    Entry("synchronisation", ("E04",), "5", "armside.scripts.thesis.chapter5:synchronisation"),
    Entry("5.4", ("E05",), "5", "armside.scripts.thesis.chapter5:sequential"),
    Entry("5.5", ("E03", "E06", "5.6"), "5", "armside.scripts.thesis.chapter5:simultaneous"),
    Entry("5.7", ("E07",), "5", "armside.scripts.thesis.chapter5:position"),
    Entry("5.8", ("E08",), "5", "armside.scripts.thesis.chapter5:angular_velocity"),
    Entry("5.9", ("E09",), "5", "armside.scripts.thesis.chapter5:acceleration"),
    Entry("5.10", ("E10",), "5", "armside.scripts.thesis.chapter5:error_along"),
    Entry("8.3", ("S01",), "8", "armside.scripts.thesis.chapter8:joint"),
    Entry("8.4", ("S02",), "8", "armside.scripts.thesis.chapter8:reference"),
    Entry("8.5", ("S02",), "8", "armside.scripts.thesis.chapter8:tracking"),
    Entry("8.6", ("S03",), "8", "armside.scripts.thesis.chapter8:criterion"),
    Entry("8.7", ("S04",), "8", "armside.scripts.thesis.chapter8:admissible_gain"),
    Entry("8.8", ("S05",), "8", "armside.scripts.thesis.chapter8:learning_curves"),
    Entry("8.9", ("S06",), "8", "armside.scripts.thesis.chapter8:motor_signals"),
    Entry("8.10", ("S06",), "8", "armside.scripts.thesis.chapter8:arm_signals"),
    Entry("8.11", ("S06",), "8", "armside.scripts.thesis.chapter8:model_error"),
    Entry("8.12", ("S06",), "8", "armside.scripts.thesis.chapter8:arm_signals_with_error"),
    Entry("9.5", ("X04",), "9", "armside.scripts.thesis.chapter9.sections:by_position"),
    Entry("9.6", ("X04",), "9", "armside.scripts.thesis.chapter9.sections:by_velocity"),
    Entry(
        "repeatability",
        ("X05", "9.10"),
        "9",
        "armside.scripts.thesis.chapter9.sections:repeatability",
    ),
    Entry("9.7", ("X06",), "9", "armside.scripts.thesis.chapter9.sections:ten_iterations"),
    Entry(
        "9.8",
        ("X07", "9.12", "9.13"),
        "9",
        "armside.scripts.thesis.chapter9.sections:identified_model",
    ),
    Entry("9.9", ("X08",), "9", "armside.scripts.thesis.chapter9.sections:positions_motor"),
    Entry("9.10", ("X08", "9.1"), "9", "armside.scripts.thesis.chapter9.sections:circles"),
    Entry("9.11", ("X08",), "9", "armside.scripts.thesis.chapter9.sections:positions_arm"),
    Entry("9.12", ("X09",), "9", "armside.scripts.thesis.chapter9.sections:shifts_motor"),
    Entry("9.13", ("X09",), "9", "armside.scripts.thesis.chapter9.sections:shifts_arm"),
    Entry("9.14", ("X10",), "9", "armside.scripts.thesis.chapter9.sections:cutoffs_motor"),
    Entry("9.15", ("X10",), "9", "armside.scripts.thesis.chapter9.sections:cutoffs_spread"),
    Entry("9.16", ("X10",), "9", "armside.scripts.thesis.chapter9.sections:cutoffs_arm"),
    Entry("9.17", ("X10",), "9", "armside.scripts.thesis.chapter9.sections:cutoffs_circles"),
    Entry("F08", (), "9", "armside.scripts.thesis.chapter9.designs:per_motor"),
    Entry("F09", (), "9", "armside.scripts.thesis.chapter9.designs:friction_feedforward"),
    Entry("F07", (), "", "armside.scripts.thesis.chapter9.robustness:individuals"),
    Entry("9-map", (), "", "armside.scripts.thesis.chapter9.robustness:phenomena_map"),
    Entry("9-effects", (), "", "armside.scripts.thesis.chapter9.robustness:effects"),
)
"""In the order of the report."""


def _check_report(_type: object, out: Path | None) -> None:
    if out is not None:
        ReportFolder(out)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ReportOptions(Common):
    """Options of every command, with a folder that may hold an earlier report."""

    out: Annotated[Path | None, Parameter(validator=_check_report)] = None
    """Folder of the report, new, empty, or an earlier report to be continued [default:
    runs/report]."""


Ids = Annotated[
    str,
    Parameter(
        help="Chapters (5, 8, 9), figures (8.7) or rows of the map (X05) [default: all chapters]."
    ),
]


def reproduce(*ids: Ids, common: ReportOptions = ReportOptions()) -> None:
    """Make figures and numbers of the thesis again and compare them, in one report.

    Writes report.html, which needs no network, report.md with figures/, and report.json. What an
    earlier or interrupted call has finished in the same folder is not run again.
    """
    report = Report(common)
    with checking_input():
        chosen = select(ids)
        folder = ReportFolder(common.out or RUNS / "report")
        parts = [(entry, _part(entry, common.seed)) for entry in chosen]
    store = Store(folder.results)
    jobs = missing([job for _, part in parts for job in part.jobs], store)
    config = summary("reproduce", {"ids": [entry.id for entry in chosen]}, common)["config"]
    folder.begin(config)
    n_known = len({store.file(job) for _, part in parts for job in part.jobs}) - len(jobs)
    total = sum(job.cost for job in jobs) + DRAWING * len(parts)
    try:
        with report.weighted_progress("reproducing", total) as step:
            with Workers() as workers:
                run_batch(jobs, store, workers=workers, done=step)
                later = [
                    job
                    for _, part in parts
                    if part.follow_up is not None
                    for job in part.follow_up(store.load)
                ]
                run_batch(missing(later, store), store, workers=workers)
            for entry, part in parts:
                section = part.draw(store.load, folder.figures)
                folder.keep(replace(section, id=entry.id, made_with=_made_with(entry, config)))
                step(DRAWING)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; what is finished is kept in {folder.path}, repeat the command to go on"
        ) from None
    sections = folder.sections([entry.id for entry in ENTRIES])
    _write_pages(folder, sections, config)
    _print(report, sections, chosen, folder, len(jobs), n_known)


def _part(entry: Entry, seed: int) -> Part:
    return load(entry.part)(seed)


def select(ids: Sequence[str]) -> list[Entry]:
    """Entries of these names in the order of the report; no names: those of all chapters."""
    if not ids:
        return [entry for entry in ENTRIES if entry.chapter]
    for name in ids:
        if not any(_is_named(entry, name) for entry in ENTRIES):
            names = dict.fromkeys(n for e in ENTRIES for n in (e.chapter, e.id, *e.also) if n)
            raise unknown("figure, chapter or row", name, names)
    return [entry for entry in ENTRIES if any(_is_named(entry, name) for name in ids)]


def _is_named(entry: Entry, name: str) -> bool:
    return bool(name) and name in (entry.id, *entry.also, entry.chapter)


def _made_with(entry: Entry, config: dict) -> dict[str, str]:
    versions = {name: str(number) for name, number in config["versions"].items()}
    command = f"armside reproduce {entry.id} --seed {config['seed']}"
    return {"Made by": f"`{command}`"} | versions


def _write_pages(folder: ReportFolder, sections: list[Section], config: dict) -> None:
    write_whole(folder.path / "report.md", markdown(TITLE, sections))
    write_whole(folder.path / "report.html", html(TITLE, sections, folder.figures))
    checks = [{"id": s.id, "title": s.title, "checks": as_rows(s.checks)} for s in sections]
    finished = {"kind": "armside report", "status": "done", "config": config, "sections": checks}
    write_whole(folder.path / MARKER, dumps(finished))


def _print(
    report: Report,
    sections: list[Section],
    chosen: list[Entry],
    folder: ReportFolder,
    n_run: int,
    n_known: int,
) -> None:
    asked = {entry.id for entry in chosen}
    shown = [section for section in sections if section.id in asked]
    rows = [
        [s.id, c.id, c.statement, c.thesis, float(c.ours), c.band, "holds" if c.holds else "FAILS"]
        for s in shown
        for c in s.checks
    ]
    if rows:
        columns = ["section", "", "what", "thesis", "ours", "band", "verdict"]
        report.table("Comparisons with the thesis", columns, rows)
        report.line(f"{count(shown)}.")
    for grid in [grid for s in shown if not s.checks for grid in s.grids]:
        report.table(grid.title, grid.columns, grid.rows)
    report.line(f"{n_run} experiments run, {n_known} known from before.")
    report.line(f"Report in {folder.path / 'report.html'}")
    report.summary(
        {
            "config": asdict(report.common),
            "status": "done",
            "sections": [{"id": s.id, "checks": as_rows(s.checks)} for s in shown],
        }
    )
