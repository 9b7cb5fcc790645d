"""A report as data: sections with a figure, a caption and checks whose verdicts are computed."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from armside.sim.evaluation.check import Check, Table
from armside.sim.records.atomic import remove_stale, write_whole
from armside.sim.records.run_folder import check_destination, check_shared_folder
from armside.sim.records.summary import dumps, plain

from ..jobs.store import Job, Result
from ..shell.errors import InputError

if TYPE_CHECKING:
    from armside.ilc.two_mass_study import Study

MARKER = "report.json"
KIND = "armside report"
RESULTS, SECTIONS, FIGURES = "results", "sections", "figures"
Read = Callable[[Job], Result]
"""Reader of the result of a job."""


class Band(NamedTuple):
    """A number of a work: its meaning, the work's own, and where ours should lie."""

    statement: str
    stated: str
    low: float | None = None
    high: float | None = None

    def check(self, id: str, ours: ArrayLike, reason: str = "") -> Check:
        """Our number, judged."""
        low, high = self.low, self.high
        return Check(id, self.statement, self.stated, float(np.asarray(ours)), low, high, reason)


@dataclass(frozen=True)
class Section:
    """The counterpart of one figure or number of the thesis."""

    id: str
    title: str
    caption: str
    """In our words, one or more sentences."""
    figures: Sequence[str] = ()
    """Names of files in the folder of figures."""
    checks: Sequence[Check] = ()
    tables: Sequence[Table] = ()
    made_with: Mapping[str, str] = field(default_factory=dict)
    """Versions, seed and command."""
    source: str = "thesis"
    """Kind of work whose numbers the checks are beside."""


@dataclass(frozen=True)
class Part:
    """The making of a section: jobs to run, and the function that draws and compares results."""

    jobs: Sequence[Job]
    draw: Callable[[Read, Path], Section]
    """Called with a reader of results and the folder for figures."""
    follow_up: Callable[[Read], Sequence[Job]] | None = None
    """Further jobs that depend on the results of the first."""


class AbsentError(InputError):
    """A set of measurements is not in the folder of data."""


@dataclass(frozen=True)
class Asked:
    """What sections are made of, beside the thesis."""

    seed: int = 0
    data: Path | None = None
    """Folder with the sets of measurements of real arms."""
    study: "Study | None" = None
    """Other joint, design or law for chapter 8."""


@dataclass(frozen=True)
class Entry:
    """One section that can be asked for."""

    id: str
    make: Callable[[Asked], Part]
    also: tuple[str, ...] = ()
    """Other names: rows of the map, equations."""
    alone: bool = False
    """Only made by its own name: it takes minutes, or the thesis does not have it."""


class ReportFolder:
    """A folder that a report grows in: results, figures, sections and the two pages.

    It is ours if it holds the marker file. A finished section stays until it is made again.
    """

    def __init__(self, path: Path) -> None:
        """Raises InputError unless the folder is new, empty, or an earlier report of ours."""
        self.path = path
        remove_stale(path)  # of a process that was killed before its marker was there
        if not (path.is_dir() and _is_report(path)):
            check_destination(path)
            check_shared_folder(path)
        self.results, self.figures = path / RESULTS, path / FIGURES

    def begin(self, config: Any) -> None:
        """Make the folder and its marker: from here on an interrupted report can be resumed."""
        self.path.mkdir(parents=True, exist_ok=True)
        write_whole(self.path / MARKER, dumps({"kind": KIND, "status": "begun", "config": config}))
        self.figures.mkdir(exist_ok=True)
        (self.path / SECTIONS).mkdir(exist_ok=True)

    def keep(self, section: Section) -> None:
        """Keep a section, in place of one of the same id."""
        write_whole(self.path / SECTIONS / f"{section.id}.json", dumps(asdict(section)))

    def sections(self, order: Sequence[str]) -> list[Section]:
        """All sections that are kept, in this order of ids."""
        files = [self.path / SECTIONS / f"{name}.json" for name in order]
        return [_section(file) for file in files if file.is_file()]


def _is_report(path: Path) -> bool:
    marker = path / MARKER
    try:
        if not marker.is_file():
            return False
        found = json.loads(marker.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path} cannot be read as a report: {MARKER}: {error}") from error
    if not isinstance(found, dict) or found.get("kind") != KIND:
        raise InputError(f"{path} holds a {MARKER} that is not of ours; give another folder")
    return True


def _section(file: Path) -> Section:
    try:
        raw = json.loads(file.read_text(encoding="utf-8"))
        for entry in raw["checks"]:
            entry["ours"] = np.nan if entry["ours"] is None else entry["ours"]
        checks = [Check(**entry) for entry in raw.pop("checks")]
        tables = [Table(**entry) for entry in raw.pop("tables")]
        if outside := [name for name in raw["figures"] if Path(name).name != name]:
            raise ValueError(f"figure {outside[0]!r} is not in the folder of figures")
        return Section(**raw, checks=checks, tables=tables)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{file} is not a section of a report: {error}") from error


def as_rows(checks: Sequence[Check]) -> list[dict[str, Any]]:
    """Checks with their verdicts, as JSON."""
    return [plain(check) | {"holds": check.holds} for check in checks]
