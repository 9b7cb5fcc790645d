"""`armside verify NAME`: the full instance of a claim, over many seeds, as a table in the docs.

A claim is a function `(seeds) -> Table` and one line in CLAIMS. The test suite calls the same
function with one or two seeds; this command calls it with all of them.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from cyclopts import Parameter

from armside.sim.records.atomic import write_whole
from armside.sim.records.summary import summary

from ..shell.console import Report, cell, keep
from ..shell.errors import RunFailed
from ..shell.options import Common, options
from ..shell.registry import load, unknown


class Verdict(NamedTuple):
    """One statement about all rows of a table, and whether it holds."""

    statement: str
    holds: bool


@dataclass(frozen=True)
class Table:
    """What a claim found: one row per case, and what follows from them."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    verdicts: Sequence[Verdict]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"a row has {len(row)} cells for {len(self.columns)} columns")


class Claim(NamedTuple):
    """Where the function is, and how many seeds its full instance takes."""

    function: str
    n_seeds: int


CLAIMS: dict[str, Claim] = {
    "kinematics": Claim("armside.scripts.verifications.kinematics:kinematics", n_seeds=10),
    "laser": Claim("armside.scripts.verifications.laser:laser", n_seeds=20),
    "ablations": Claim("armside.scripts.verifications.ablations:ablations", n_seeds=3),
    "env": Claim("armside.scripts.verifications.env:env", n_seeds=1000),
    "tuning": Claim("armside.scripts.verifications.tuning:tuning", n_seeds=100),
    "tuning-iterations": Claim("armside.scripts.verifications.tuning:iterations", n_seeds=100),
    "sweep": Claim("armside.scripts.verifications.sweep:sweep", n_seeds=10),
    "sweep-memory": Claim("armside.scripts.verifications.sweep:memory", n_seeds=10_000),
    "chapter9": Claim("armside.scripts.verifications.chapter9:chapter9", n_seeds=5),
    "imu": Claim("armside.scripts.verifications.irb1400:imu", n_seeds=20),
    "estimation": Claim("armside.scripts.verifications.estimation:estimation", n_seeds=10),
    "estimation-controls": Claim("armside.scripts.verifications.controls:controls", n_seeds=10),
    "imu-causes": Claim("armside.scripts.verifications.irb1400:imu_causes", n_seeds=5),
    "imu-large": Claim("armside.scripts.verifications.imu_large:imu_large", n_seeds=10),
    "imu-rest": Claim("armside.scripts.verifications.irb1400:rest", n_seeds=10),
    "laser-irb1400": Claim("armside.scripts.verifications.irb1400_laser:laser", n_seeds=20),
    "laser-irb1400-design": Claim("armside.scripts.verifications.irb1400_laser:design", n_seeds=20),
}
"""Name: claim. A new claim is one line here."""


@options
@dataclass(frozen=True, kw_only=True)
class VerifyCfg:
    """How much of a claim to verify."""

    seeds: int | None = None
    """Number of seeds, counted up from --seed [default: the full instance of the claim]."""
    docs: Path = Path("docs")
    """Folder where verify-NAME.md is written."""

    def __post_init__(self) -> None:
        if self.seeds is not None and self.seeds < 1:
            raise ValueError(f"seeds must be >= 1, got {self.seeds}")


Name = Annotated[str, Parameter(help=f"Which claim: {', '.join(CLAIMS)}.")]


def verify(name: Name, /, *, cfg: VerifyCfg = VerifyCfg(), common: Common = Common()) -> None:
    """Check a claim over many seeds, print its table and write it to docs/verify-NAME.md."""
    if name not in CLAIMS:
        raise unknown("claim", name, CLAIMS)
    n_seeds = cfg.seeds or CLAIMS[name].n_seeds
    seeds = range(common.seed, common.seed + n_seeds)
    report = Report(common)
    with report.progress(f"verifying {name}", total=n_seeds) as step:
        table: Table = load(CLAIMS[name].function)(_Counted(seeds, step))
    outcome = summary(
        "verify",
        {"name": name, "seeds": n_seeds, "docs": cfg.docs},
        common,
        status="done" if all(v.holds for v in table.verdicts) else "failed",
        table=table,
    )
    cfg.docs.mkdir(parents=True, exist_ok=True)
    command = f"armside verify {name} --seeds {n_seeds} --seed {common.seed}"
    page = markdown(table, command, outcome["config"]["versions"])
    write_whole(cfg.docs / f"verify-{name}.md", page)
    keep(outcome, common)

    report.table(table.title, table.columns, table.rows)
    for verdict in table.verdicts:
        report.line(f"{'holds' if verdict.holds else 'FAILS'}: {verdict.statement}")
    report.summary(outcome)
    failed = [verdict.statement for verdict in table.verdicts if not verdict.holds]
    if failed:
        raise RunFailed(f"{len(failed)} of {len(table.verdicts)} statements fail: {failed[0]}")


def markdown(table: Table, command: str, versions: dict[str, str]) -> str:
    """The page of a table: what made it, what it says, and every row."""
    made_by = ", ".join(f"{name} {number}" for name, number in versions.items())
    verdicts = [f"- {'holds' if v.holds else '**fails**'}: {v.statement}" for v in table.verdicts]
    rows = [[cell(value) for value in row] for row in table.rows]
    lines = [list(table.columns), ["---"] * len(table.columns), *rows]
    grid = ["| " + " | ".join(words) + " |" for words in lines]
    head = [f"# {table.title}", "", f"Written by `{command}` with {made_by}.", ""]
    return "\n".join([*head, *verdicts, "", *grid]) + "\n"


class _Counted(tuple[int, ...]):
    """Seeds that count themselves done as they are iterated."""

    _step: Callable[[], None]

    def __new__(cls, seeds: Sequence[int], step: Callable[[], None]) -> "_Counted":
        self = super().__new__(cls, seeds)
        self._step = step
        return self

    def __iter__(self) -> Iterator[int]:
        for seed in super().__iter__():
            yield seed
            self._step()
