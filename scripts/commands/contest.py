"""`armside contest`: entries of learning control on sealed tasks, judged and ranked."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from armside.sim.records.run_folder import check_shared_folder
from armside.sim.records.summary import summary

from ..shell.console import Report, run_folder
from ..shell.errors import InputError, RunFailed, checking_input
from ..shell.options import Common, Count, Folder, Limits, options

if TYPE_CHECKING:
    from armside.sim.contest.seal import Round

Action = Annotated[
    Literal["run", "judge", "table", "check", "new-round"], Parameter(help="See above.")
]
Files = Annotated[Path, Parameter(help="Entries, results, or the name of the new round.")]
TrackName = Literal["joint", "motor", "imu", "tracker", "first", "drift", "part"]
MOST_TASKS = 10_000


@options
@dataclass(frozen=True, kw_only=True)
class ContestOptions:
    """Track, round and number of tasks."""

    track: TrackName = "joint"
    """Track."""
    tasks: Count = 100
    """Number of tasks, from the first on; with `check`, that the result must have."""
    round: str = "development"
    """`development`, or the file NAME.json of a round."""
    salt: str | None = None
    """Salt of the round: 64 hex digits, or a file with them."""
    into: Folder = Path("contest")
    """Folder of the results, one JSON for each entry, track and round; gone on from."""
    entry: Path | None = None
    """With `check`: the file of the entry that the result is of."""

    def __post_init__(self) -> None:
        Limits(1, MOST_TASKS).check("tasks", self.tasks)

    @property
    def judged_round(self) -> "Round":
        """The round, with its salt. Raises InputError."""
        from armside.sim.contest.seal import DEVELOPMENT, Round, read_round

        if self.round == DEVELOPMENT:
            if self.salt is not None:
                raise InputError(f"the round {DEVELOPMENT} has no salt: leave --salt out")
            return Round()
        if self.salt is None:
            raise InputError(f"the round {self.round} is sealed: judging it needs --salt")
        return read_round(Path(self.round), self.salt)


def contest(
    action: Action,
    /,
    *files: Files,
    cfg: ContestOptions = ContestOptions(),
    common: Common = Common(),
) -> None:
    """An open contest of learning control. See docs/contest.md for its rules.

    run ENTRY.py...: play tasks of the public round. judge ENTRY.py...: of a sealed one, with
    --round FILE and --salt. table RESULT.json...: scores with intervals and ranks, with --out a
    chart; without files all of --into. check RESULT.json --entry ENTRY.py: play a random tenth
    again. new-round NAME: seal a round; NAME.json is to be published, NAME.salt kept until it ends.
    """
    report = Report(common)
    done = {"table": _table, "check": _check, "new-round": _new_round}.get(action, _play)
    done(action, files, cfg, report)


def _summary(cfg: ContestOptions, report: Report, **results: Any) -> dict[str, Any]:
    """Without the salt, which is published when the round ends and not by a summary."""
    return summary("contest", replace(cfg, salt=None), report.common, **results)


def _play(action: str, files: tuple[Path, ...], cfg: ContestOptions, report: Report) -> None:
    from armside.sim.contest.judge import judged, source_of
    from armside.sim.contest.tracks import track

    with checking_input():
        round, of = cfg.judged_round, track(cfg.track)
        if (action == "judge") != round.judged:
            needed = "judge needs --round FILE and --salt, run takes neither"
            raise InputError(f"contest {action}: {needed}")
        if not files:
            raise InputError(f"contest {action} needs the file of an entry")
        for file in files:
            source_of(file)
        check_shared_folder(cfg.into)
    cfg.into.mkdir(parents=True, exist_ok=True)
    results = list[dict[str, Any]]()
    for file in files:
        result = cfg.into / f"{file.stem}-{of.name}-{round.name}.json"
        with report.progress(f"{file.stem}, {of.name}", cfg.tasks) as step:
            results.append(judged(result, file, of.name, round, cfg.tasks, step))
    _show(results, cfg, report)


def _table(_: str, files: tuple[Path, ...], cfg: ContestOptions, report: Report) -> None:
    from armside.sim.contest.judge import read_result

    with checking_input():
        results = [read_result(f) for f in files or _results(cfg.into)]
        if not results:
            raise InputError(f"there is no result in {cfg.into}")
    _show(results, cfg, report, whole=bool(files))


def _results(folder: Path) -> list[Path]:
    """Files of a folder that are no published rounds."""
    return [f for f in sorted(folder.glob("*.json")) if not f.with_suffix(".salt").exists()]


def _check(_: str, files: tuple[Path, ...], cfg: ContestOptions, report: Report) -> None:
    from armside.sim.contest.judge import checked, read_result, source_of

    with checking_input():
        if len(files) != 1 or cfg.entry is None:
            raise InputError("contest check needs one result and --entry with the entry's file")
        round, result = cfg.judged_round, read_result(files[0])
        source = source_of(cfg.entry)
    wrong = list(checked(result, source, round, cfg.tasks))
    report.kept(_summary(cfg, report, wrong=wrong), *wrong)
    if wrong:
        raise RunFailed(f"{files[0]} does not come out the same: {wrong[0]}")
    report.lines([f"{files[0]}: a random tenth of {len(result['tasks'])} tasks comes out the same"])


def _new_round(_: str, files: tuple[Path, ...], cfg: ContestOptions, report: Report) -> None:
    from armside.sim.contest.seal import new_round

    with checking_input():
        if len(files) != 1 or files[0].name != str(files[0]):
            raise InputError("contest new-round needs one name")
        cfg.into.mkdir(parents=True, exist_ok=True)
        made = new_round(files[0].name, cfg.into)
    kept = f"{cfg.into / made.name}.json is to be published, {made.name}.salt kept until the end"
    report.kept(_summary(cfg, report, salt_sha256=made.digest), kept)


COLUMNS = ["entry", "rank", "left", "low", "high", "harm", "worst", "lost", "runs", "s a task"]


def _show(
    results: list[dict[str, Any]], cfg: ContestOptions, report: Report, *, whole: bool = True
) -> None:
    """A table for each track and round. whole: refuse results that cannot be ranked, and do not
    leave out their table alone."""
    from armside.sim.contest.table import table
    from armside.sim.contest.tracks import track

    groups: dict[str, list[dict[str, Any]]] = {}
    for result in results:
        groups.setdefault(f"{result['track']}-{result['round']}", []).append(result)
    tables, left_out = dict[str, tuple[list[dict[str, Any]], int]](), list[str]()
    for name, group in groups.items():
        try:
            tables[name] = table(group)
        except ValueError as error:
            left_out.append(f"no table of {name}: {error}")
    if left_out and (whole or not tables):
        raise InputError(left_out[0])
    shown = [{"name": name, "tasks": n, "standings": rows} for name, (rows, n) in tables.items()]
    found = _summary(cfg, report, tables=shown, notes=left_out)
    if report.common.out is not None:
        from ..figures.contest import draw

        with run_folder(found, report.common) as folder:
            for name, group in groups.items():
                if name not in tables:
                    continue
                draw(folder / f"{name}.png", group, name)
    for name, (rows, n) in tables.items():
        score = track(groups[name][0]["track"]).score
        cells = [list(row.values())[: len(COLUMNS)] for row in rows]
        report.table(f"{name}, {n} tasks: {score}", COLUMNS, cells)
        for row in rows:
            report.lines(f"Lost by {row['entry']}: {why}" for why in row["reasons"])
    report.notes(left_out)
    report.summary(found)
