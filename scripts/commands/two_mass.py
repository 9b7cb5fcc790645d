"""`armside two-mass`: the simulation study of chapter 8, figure by figure."""

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from armside.sim.records.run_folder import RunFolder
from armside.sim.records.summary import dumps, summary

from ..shell.console import Report
from ..shell.errors import checking_input, unknown
from ..shell.options import Common, options

BEYOND = ("nyquist", "why-q", "algorithms", "robustness", "friction")
FIGURE_NAMES = (*(f"8.{i}" for i in range(3, 13)), *BEYOND)
"""Keys of `FIGURES`, which this module does not import: a wrong name is found without drawing."""


@options
@dataclass(frozen=True, kw_only=True)
class TwoMassCfg:
    """Figures to draw."""

    figure: Annotated[tuple[str, ...], Parameter(consume_multiple=True)] = ("all",)
    """8.3 to 8.12 as in the thesis; nyquist, why-q, algorithms, robustness, friction; or all."""
    joint: Annotated[tuple[str, ...], Parameter(consume_multiple=True)] = ()
    """Other numbers of the joint and its controller, KEY=VALUE in SI units: Jm, Ja (inertias), rg
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
        if not 0.0 < self.gamma <= 100.0:
            raise ValueError(f"gamma must be > 0 and at most 100, got {self.gamma:g}")
        if not 1 <= self.delta <= 100:
            raise ValueError(f"delta must be 1 to 100 samples, got {self.delta}")
        if not 0.1 <= self.cutoff <= 49.0:
            raise ValueError(f"cutoff must be 0.1 to 49 Hz, got {self.cutoff:g}")
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
    from ..workbench.two_mass import study_of

    report = Report(common)
    tables = {}
    with checking_input():
        study = study_of(cfg.joint, cfg.gamma, cfg.delta, cfg.cutoff, cfg.law)
    with RunFolder("two-mass", seed=common.seed, out=common.out) as folder:
        with report.progress("drawing", total=len(cfg.names)) as step:
            for name in cfg.names:
                tables[name] = FIGURES[name](folder / f"figure-{name}.png", common.seed, study)
                step()
        rows = {
            name: {"title": table.title, "columns": table.columns, "rows": table.rows}
            for name, table in tables.items()
        }
        outcome = summary("two-mass", cfg, common, figures=rows)
        (folder / "summary.json").write_text(dumps(outcome), encoding="utf-8")
    if not study.is_thesis:
        numbers = " ".join(cfg.joint) or "of the thesis"
        report.line(f"Not the numbers of the thesis: {study.design}; joint {numbers}")
    for table in tables.values():
        report.table(table.title, table.columns, table.rows)
    report.line(f"Results in {folder.path}")
    report.summary(outcome)
