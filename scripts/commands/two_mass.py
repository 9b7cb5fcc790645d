"""`armside two-mass`: the simulation study of chapter 8, figure by figure."""

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report
from ..shell.options import Common, options
from ..shell.registry import unknown

BEYOND = ("nyquist", "why-q", "algorithms", "robustness", "friction")
FIGURE_NAMES = (*(f"8.{i}" for i in range(3, 13)), *BEYOND)
"""Keys of `FIGURES`, which this module does not import: a wrong name is found without drawing."""


@options
@dataclass(frozen=True, kw_only=True)
class TwoMassCfg:
    """Figures to draw."""

    figure: Annotated[tuple[str, ...], Parameter(consume_multiple=True)] = ("all",)
    """8.3 to 8.12 as in the thesis; nyquist, why-q, algorithms, robustness, friction; or all."""

    def __post_init__(self) -> None:
        for name in self.figure:
            if name not in ("all", *FIGURE_NAMES):
                raise unknown("figure", name, ("all", *FIGURE_NAMES))

    @property
    def names(self) -> list[str]:
        """Names of the figures, each once, in the order of the thesis."""
        return [name for name in FIGURE_NAMES if name in self.figure or "all" in self.figure]


def two_mass(*, cfg: TwoMassCfg = TwoMassCfg(), common: Common = Common()) -> None:
    """Regenerate the figures of chapter 8 (a flexible joint that learns) with their numbers.

    Writes one PNG a figure and summary.json.
    """
    from ..figures.two_mass import FIGURES

    report = Report(common)
    tables = {}
    with RunFolder("two-mass", seed=common.seed, out=common.out) as folder:
        with report.progress("drawing", total=len(cfg.names)) as step:
            for name in cfg.names:
                tables[name] = FIGURES[name](folder / f"figure-{name}.png", common.seed)
                step()
        rows = {
            name: {"title": table.title, "columns": table.columns, "rows": table.rows}
            for name, table in tables.items()
        }
        outcome = summary("two-mass", cfg, common, figures=rows)
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    for table in tables.values():
        report.table(table.title, table.columns, table.rows)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)
