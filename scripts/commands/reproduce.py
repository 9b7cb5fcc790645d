"""`armside reproduce`: figures and numbers of the thesis again, in one report, with verdicts."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from armside.sim.records.atomic import write_whole
from armside.sim.records.run_folder import RUNS
from armside.sim.records.summary import dumps, summary

from ..jobs.store import Store, digest, missing, run_batch
from ..jobs.workers import Workers
from ..shell.console import Report
from ..shell.errors import InputError, checking_input
from ..shell.options import SOME, Common, Limits, options, path_checked
from ..thesis import entries
from ..thesis.pages import check_row, columns, count, html, markdown
from ..thesis.report import KIND, MARKER, AbsentError, Asked, Part, ReportFolder, Section, as_rows

if TYPE_CHECKING:
    from armside.ilc.two_mass_study import Study

TITLE = "The thesis made again: an IMU on a robot, learning on a joint and on a robot"
REAL = "real"
"""Chapter whose sections need --data."""
PAPERS = "Measurements of others, made again"
DRAWING = 1.5
"""Cost of drawing a section in the progress, beside the cost of jobs."""


def _check_data(data: Path) -> None:
    if not data.is_dir():
        raise ValueError(f"{data} is no folder")


_DATA = Parameter(validator=path_checked(_check_data), group="Parameters")


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ReportOptions(Common):
    """Options of every command, with a folder that may hold an earlier report."""

    out: Annotated[Path | None, Parameter(validator=path_checked(ReportFolder))] = None
    """Folder of the report, new, empty, or an earlier report to be continued [default:
    runs/report]."""
    data: Annotated[Path | None, _DATA] = None
    """Folder with the sets of measurements of real arms, for `real` (docs/real.md)."""


@options
@dataclass(frozen=True, kw_only=True)
class JointCfg:
    """Another joint, design or law in the figures of chapter 8, which are then not compared."""

    joint: Annotated[tuple[str, ...], SOME] = ()
    """Numbers of the joint and its controller, KEY=VALUE in SI units: Jm, Ja (inertias), rg
    (ratio, below 1), k, d (spring), fm (friction), kt; Kp, Kd, Tf [default: Table 8.1, (8.11)]."""
    gamma: float = 0.9
    """Gain of the heuristic law."""
    delta: int = 5
    """Its shift [samples of 10 ms]."""
    cutoff: float = 17.0
    """Cutoff of Q [Hz], where one design learns."""
    law: str | None = None
    """Law in its place in 8.4, 8.5, 8.8 to 8.12, algorithms and friction: as --laws of armside
    learn, such as norm-optimal or file.py:Name."""

    def __post_init__(self) -> None:
        Limits(0.0, 100.0, above=True).check("gamma", self.gamma)
        Limits(1, 100, "samples").check("delta", self.delta)
        Limits(0.1, 49.0, "Hz").check("cutoff", self.cutoff)

    def study(self) -> "Study | None":
        """Joint and design; None: those of the thesis."""
        if self == JointCfg():
            return None
        from ..workbench.joint import study_of

        return study_of(self.joint, self.gamma, self.delta, self.cutoff, self.law)


_IDS = (
    "Chapters (5, 8, 9), figures (8.7) or rows of the map (X05) [default: all chapters]; by name "
    "alone F07, 9-map, 9-effects, and on the joint of chapter 8 nyquist, why-q, algorithms, "
    "robustness, friction; papers, for measurements of others; real, for those of real arms, with "
    "--data."
)
Ids = Annotated[str, Parameter(help=_IDS)]


def reproduce(
    *ids: Ids, cfg: JointCfg = JointCfg(), common: ReportOptions = ReportOptions()
) -> None:
    """Make figures and numbers of the thesis again and compare them, in one report.

    papers compares with measurements of others, by T1-acceleration-motor, T1-acceleration-load,
    T1-tcp, T1-rest, T1-peak, T1-two-stage-motor, T1-two-stage-load, bench-first, bench-ten,
    bench-wrong, T2-smoother, T2-doubled, T2-online, T3-dkf, T3-kkf, L1 and N1.

    Writes report.html, which needs no network, report.md with figures/, and report.json. What an
    earlier or interrupted call has finished in the same folder is not run again.
    """
    report = Report(common)
    with checking_input():
        parts = _parts(ids, cfg, common)
        folder = ReportFolder(common.out or RUNS / "report")
    store = Store(folder.results)
    wanted = [job for part in parts.values() for job in part.jobs]
    jobs = missing(wanted, store)
    n_known = len(set(map(digest, wanted))) - len(jobs)
    config = summary("reproduce", {"ids": list(parts)} | _changed(cfg), common)["config"]
    versions = {program: str(number) for program, number in config["versions"].items()}
    folder.begin(config)
    total = sum(job.cost for job in jobs) + DRAWING * len(parts)
    try:
        with report.progress("reproducing", total, weighted=True) as step:
            with Workers() as workers:
                run_batch(jobs, store, workers=workers, done=step)
                follow_ups = [part.follow_up for part in parts.values() if part.follow_up]
                later = [job for follow_up in follow_ups for job in follow_up(store.load)]
                run_batch(missing(later, store), store, workers=workers)
            for name, part in parts.items():
                section = part.draw(store.load, folder.figures)
                call = f"`armside reproduce {name}{_options(name, cfg)} --seed {config['seed']}`"
                folder.keep(replace(section, id=name, made_with={"Made by": call} | versions))
                step(DRAWING)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; what is finished is kept in {folder.path}, repeat the command to go on"
        ) from None
    sections = folder.sections(entries.order())
    _write_pages(folder, sections, config)
    _print(report, [section for section in sections if section.id in parts])
    report.line(f"{len(jobs)} experiments run, {n_known} known from before.")
    report.line(f"Report in {folder.path / 'report.html'}")


def _parts(ids: Sequence[str], cfg: JointCfg, common: ReportOptions) -> dict[str, Part]:
    """Parts of the sections of these names; of a chapter on real arms those whose files are there.
    Raises InputError for names and options that are not allowed, and where no part is left."""
    asked, parts = Asked(common.seed, common.data, cfg.study()), dict[str, Part]()
    chosen = entries.select(ids)
    if asked.study is not None:
        of_joint = {entry.id for entry in entries.chapters()["8"]}
        if others := [entry.id for entry in chosen if entry.id not in of_joint]:
            text = "joint, gamma, delta, cutoff and law are of the figures of chapter 8"
            raise InputError(f"{text}, not of {others[0]}")
    absent: InputError | None = None
    for entry in chosen:
        try:
            parts[entry.id] = entry.make(asked)
        except AbsentError as error:
            if entry.id in ids:
                raise
            absent = error
    if not parts and absent is not None:
        raise absent
    return parts


def _changed(cfg: JointCfg) -> dict[str, Any]:
    own, usual = vars(cfg), vars(JointCfg())
    return {name: value for name, value in own.items() if value != usual[name]}


def _options(name: str, cfg: JointCfg) -> str:
    if name.startswith(f"{REAL}-"):
        return " --data FOLDER"
    words = (
        f" --{key} {' '.join(value) if isinstance(value, tuple) else value}"
        for key, value in _changed(cfg).items()
    )
    return "".join(words)


def _write_pages(folder: ReportFolder, sections: list[Section], config: dict[str, Any]) -> None:
    title = PAPERS if {section.source for section in sections} == {"paper"} else TITLE
    write_whole(folder.path / "report.md", markdown(title, sections))
    write_whole(folder.path / "report.html", html(title, sections, folder.figures))
    checks = [{"id": s.id, "title": s.title, "checks": as_rows(s.checks)} for s in sections]
    finished = {"kind": KIND, "status": "done", "config": config, "sections": checks}
    write_whole(folder.path / MARKER, dumps(finished))


def _print(report: Report, shown: list[Section]) -> None:
    rows = [[section.id, *check_row(check)] for section in shown for check in section.checks]
    if rows:
        all_ = all(c.thesis and s.source == "thesis" for s in shown for c in s.checks)
        of = " with the thesis" if all_ else ""
        report.table(f"Comparisons{of}", ["section", *columns(shown)], rows)
        failed = (c for s in shown for c in s.checks if c.reason and not c.holds)
        report.lines(f"{check.id} fails: {check.reason}" for check in failed)
        report.line(f"{count(shown)}.")
    for table in [table for section in shown if not section.checks for table in section.tables]:
        report.table(table.title, table.columns, table.rows)
    sections = [
        {"id": s.id, "checks": as_rows(s.checks), "tables": [asdict(t) for t in s.tables]}
        for s in shown
    ]
    found = {"config": asdict(report.common), "status": "done", "sections": sections}
    papers = [
        {"id": c.id, "paper": c.thesis, "band": c.band, "value": c.ours, "holds": c.holds}
        for section in shown
        if section.source == "paper"
        for c in section.checks
    ]
    report.summary(found | ({"checks": papers} if papers else {}))
