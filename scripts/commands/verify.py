"""`armside verify NAME`: the full instance of a claim, over many seeds, as a table in the docs.

The test suite calls the function of a claim with one or two seeds; this command with all of them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from armside.sim.records.atomic import write_whole
from armside.sim.records.summary import summary

from ..shell.console import Report, keep
from ..shell.effort import Effort, refuse_absurd
from ..shell.errors import RunFailed, checking_input, unknown
from ..shell.options import Common, Folder, options, seed_range
from ..thesis.pages import claim_page
from ..verifications.claims import CLAIMS

OF_A_SEED = Effort(1.0, 100.0)


@options
@dataclass(frozen=True, kw_only=True)
class VerifyCfg:
    """Extent of a verification, and place of its page."""

    seeds: int | None = None
    """Number of seeds, counted up from --seed [default: the full instance of the claim]."""
    docs: Folder = Path("docs")
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
    refuse_absurd(f"{n_seeds} seeds", OF_A_SEED * n_seeds)
    with checking_input():
        seeds = seed_range(common.seed, n_seeds)
    report = Report(common)
    with report.progress(f"verifying {name}", total=n_seeds) as step:
        counted = _Counted(seeds)
        counted.step = step
        table = CLAIMS[name].load()(counted)
    verdicts = [(verdict.statement, verdict.holds) for verdict in table.verdicts]
    failed = [statement for statement, holds in verdicts if not holds]
    config = {"name": name, "seeds": n_seeds, "docs": cfg.docs}
    shown = {name: getattr(table, name) for name in ("title", "columns", "rows")}
    shown["verdicts"], status = verdicts, "failed" if failed else "done"
    outcome = summary("verify", config, common, status=status, table=shown, notes=table.notes)
    cfg.docs.mkdir(parents=True, exist_ok=True)
    command = f"armside verify {name} --seeds {n_seeds} --seed {common.seed}"
    page = claim_page(table, command, outcome["config"]["versions"])
    write_whole(cfg.docs / f"verify-{name}.md", page)
    keep(outcome, common)

    report.notes(table.notes)
    report.table(table.title, table.columns, table.rows)
    for verdict in table.verdicts:
        report.line(f"{verdict.verdict}: {verdict.statement}")
    report.summary(outcome)
    if failed:
        raise RunFailed(f"{len(failed)} of {len(verdicts)} statements fail: {failed[0]}")


class _Counted(tuple[int, ...]):
    """Seeds that count themselves done, by `step`, as they are iterated."""

    step: Callable[[], None]

    def __iter__(self) -> Iterator[int]:
        for seed in super().__iter__():
            yield seed
            self.step()
