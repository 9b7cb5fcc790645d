"""`armside reproduce`: figures and numbers of the thesis again, in one report, with verdicts."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from armside.sim.records.atomic import write_whole
from armside.sim.records.run_folder import RUNS
from armside.sim.records.summary import dumps, summary

from ..jobs.store import Store, missing, run_batch
from ..jobs.workers import Workers
from ..shell.console import Report
from ..shell.errors import checking_input
from ..shell.options import Common
from ..thesis import entries
from ..thesis.pages import COLUMNS, check_row, count, html, markdown
from ..thesis.report import KIND, MARKER, Part, ReportFolder, Section, as_rows

TITLE = "The thesis made again: an IMU on a robot, learning on a joint and on a robot"
REAL = ("real-ur10", "real-irb120", "real-imu", "real-gears", "real-paths")
"""Sections on measurements of real arms, in the order of the report."""
DRAWING = 1.5
"""Cost of drawing a section in the progress, beside the cost of jobs."""


def _check_report(_type: object, out: Path | None) -> None:
    if out is not None:
        ReportFolder(out)


def _check_data(_type: object, data: Path | None) -> None:
    if data is not None and not data.is_dir():
        raise ValueError(f"{data} is no folder")


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ReportOptions(Common):
    """Options of every command, with a folder that may hold an earlier report."""

    out: Annotated[Path | None, Parameter(validator=_check_report)] = None
    """Folder of the report, new, empty, or an earlier report to be continued [default:
    runs/report]."""
    data: Annotated[Path | None, Parameter(validator=_check_data)] = None
    """Folder with the sets of measurements of real arms, for `real` (docs/real.md)."""


_IDS = (
    "Chapters (5, 8, 9), figures (8.7) or rows of the map (X05) [default: all chapters]; real, for "
    "measurements of real arms, with --data."
)
Ids = Annotated[str, Parameter(help=_IDS)]


def reproduce(*ids: Ids, common: ReportOptions = ReportOptions()) -> None:
    """Make figures and numbers of the thesis again and compare them, in one report.

    Writes report.html, which needs no network, report.md with figures/, and report.json. What an
    earlier or interrupted call has finished in the same folder is not run again.
    """
    report = Report(common)
    with checking_input():
        parts = _parts(ids, common)
        folder = ReportFolder(common.out or RUNS / "report")
    store = Store(folder.results)
    wanted = [job for part in parts.values() for job in part.jobs]
    jobs = missing(wanted, store)
    n_known = len({store.file(job) for job in wanted}) - len(jobs)
    config = summary("reproduce", {"ids": list(parts)}, common)["config"]
    versions = {program: str(number) for program, number in config["versions"].items()}
    folder.begin(config)
    total = sum(job.cost for job in jobs) + DRAWING * len(parts)
    try:
        with report.weighted_progress("reproducing", total) as step:
            with Workers() as workers:
                run_batch(jobs, store, workers=workers, done=step)
                follow_ups = [part.follow_up for part in parts.values() if part.follow_up]
                later = [job for follow_up in follow_ups for job in follow_up(store.load)]
                run_batch(missing(later, store), store, workers=workers)
            for name, part in parts.items():
                section = part.draw(store.load, folder.figures)
                call = f"`armside reproduce {name}{_of_data(name)} --seed {config['seed']}`"
                folder.keep(replace(section, id=name, made_with={"Made by": call} | versions))
                step(DRAWING)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; what is finished is kept in {folder.path}, repeat the command to go on"
        ) from None
    order = [entry.id for entry in entries.ENTRIES] + [*REAL]
    sections = folder.sections(order)
    _write_pages(folder, sections, config)
    _print(report, [section for section in sections if section.id in parts])
    report.line(f"{len(jobs)} experiments run, {n_known} known from before.")
    report.line(f"Report in {folder.path / 'report.html'}")


def _parts(ids: Sequence[str], common: ReportOptions) -> dict[str, Part]:
    """Parts of the sections of these names; those on real arms are imported when asked for."""
    real = [id for id in ids if id == "real" or id in REAL]
    others = [id for id in ids if id not in real]
    chosen = [] if real and not others else entries.select(others)
    parts = {entry.id: entry.load()(common.seed) for entry in chosen}
    if real:
        from ..thesis import measured

        parts |= measured.parts(real, common.data, common.seed)
    return parts


def _of_data(name: str) -> str:
    return " --data FOLDER" if name in REAL else ""


def _write_pages(folder: ReportFolder, sections: list[Section], config: dict[str, Any]) -> None:
    write_whole(folder.path / "report.md", markdown(TITLE, sections))
    write_whole(folder.path / "report.html", html(TITLE, sections, folder.figures))
    checks = [{"id": s.id, "title": s.title, "checks": as_rows(s.checks)} for s in sections]
    finished = {"kind": KIND, "status": "done", "config": config, "sections": checks}
    write_whole(folder.path / MARKER, dumps(finished))


def _print(report: Report, shown: list[Section]) -> None:
    rows = [[section.id, *check_row(check)] for section in shown for check in section.checks]
    if rows:
        report.table("Comparisons with the thesis", ["section", *COLUMNS], rows)
        report.line(f"{count(shown)}.")
    for table in [table for section in shown if not section.checks for table in section.tables]:
        report.table(table.title, table.columns, table.rows)
    checks = [{"id": section.id, "checks": as_rows(section.checks)} for section in shown]
    report.summary({"config": asdict(report.common), "status": "done", "sections": checks})
