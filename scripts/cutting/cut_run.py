"""A run of `armside laser`, `cut` or a sweep: what it starts from, what it learns from, its end."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from armside.sim.laser.experiment import Experiment, Iteration, prepare
from armside.sim.laser.loop import Start, iterate
from armside.sim.laser.measures import Measure
from armside.sim.laser.results import iteration_row, results
from armside.sim.laser.specification import Setup
from armside.sim.notes import Note

from ..shell.console import Report
from ..shell.errors import RunFailed
from .earlier import Earlier
from .options import LaserCfg
from .specification import cut, measure

if TYPE_CHECKING:
    from armside.sim.twin.first_cut import FirstCut

_ENDS = {
    "diverged": "learning diverged at iteration {k}",
    "worse": "learning made the tool worse than before",
    "saturated": "at iteration {k} an axis ran into its hard stop, or every drive was at its "
    "torque limit: see `armside robot check`",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Ready:
    """An experiment, what it learns from and what it starts from."""

    experiment: Experiment
    measure: Measure
    start: Start | None = None
    by_twin: "FirstCut | None" = None
    earlier: Earlier | None = None

    def corrected_by(self, twin: Path | None) -> "Ready":
        """With a first run that the twin of a folder corrects, unless it has a start already.
        Raises ValueError for a folder without a twin, or one of another robot."""
        if twin is None:
            return self
        from armside.sim.twin.first_cut import first_cut

        found = first_cut(twin, self.experiment)
        start = found.start if self.earlier is None else self.start
        measure = found.around(self.measure, self.experiment)
        return replace(self, by_twin=found, measure=measure, start=start)

    def iterations(self, count: int, converged: float | None = None) -> Iterator[Iteration]:
        """As of `iterate`."""
        set_up = self.measure.prepare(self.experiment)
        return iterate(self.experiment, set_up, count, start=self.start, converged=converged)

    def entries(self) -> tuple[dict[str, Any], list[Note]]:
        """Entries of summary.json on what it started from, and notes."""
        if self.earlier is not None:
            entry = self.earlier.entry
            if self.earlier.changed:
                fresh = prepare(self.experiment.cut, seed=self.experiment.seed)
                first = next(iterate(fresh, self.measure.prepare(fresh), 0))
                entry["uncorrected"] = iteration_row(first)
            return {"started_from": entry}, []
        if self.by_twin is not None:
            return {"predicted": self.by_twin.predicted}, self.by_twin.notes
        return {}, []

    def show(self, report: Report, outcome: Mapping[str, Any]) -> None:
        """Print what it started from."""
        rows = outcome["iterations"]
        if self.earlier is not None:
            report.line(self.earlier.line)
            without = outcome["started_from"].get("uncorrected", {}).get("arm_rms")
            if None not in (without, first := rows[0]["arm_rms"]):
                figures = f"{1e6 * first:.4g} um, {1e6 * without:.4g} um without it"
                report.line(f"Its first run, with that correction: RMS {figures}")
        if "predicted" in outcome:
            report.line(predicted_line(outcome["predicted"], rows))


def ready(cut: Setup, measure: Measure, seed: int, before: Earlier | None = None) -> Ready:
    """An experiment before its first run, from an earlier one if given. Raises ValueError for what
    cannot be done."""
    experiment = prepare(cut, seed=seed)
    measure.prepare(experiment)  # raises for a robot that it cannot serve
    start = None if before is None else before.start(experiment.motion)
    return Ready(experiment=experiment, measure=measure, start=start, earlier=before)


def run(cfg: LaserCfg, seed: int) -> dict[str, Any]:
    """Status, limits and measures of a cut that is learned, as `results` arranges them; with a twin
    also `predicted`, as `armside laser` has it."""
    made = ready(cut(cfg), measure(cfg), seed).corrected_by(cfg.twin)
    of_tool = cfg.measure != "motor"
    found = results(made.experiment, made.iterations(cfg.iterations), of_tool=of_tool)
    return found if made.by_twin is None else found | {"predicted": made.by_twin.predicted}


def predicted_line(predicted: Mapping[str, Any], rows: list[dict[str, Any]]) -> str:
    """What was predicted of the first run and what was measured. The interval is that of a run with
    the correction: it is not printed where that is not used, nor where it was not fitted to twins
    by that sensor and of so few cuts."""
    first, uncorrected = rows[0]["arm_rms"], f"{1e6 * predicted['uncorrected']:.0f} um"
    seen = "not measured" if first is None else f"{1e6 * first:.1f} um"
    if not predicted["trusted"]:
        return (
            f"First cut without correction: {seen}, {uncorrected} by the twin, which is not trusted"
        )
    text = (
        f"First cut by the twin: {seen}, {uncorrected} without correction; "
        f"predicted {1e6 * predicted['arm_rms']:.1f} um"
    )
    if predicted["interval"] is None:
        return f"{text}, of unknown accuracy"
    low, high = (1e6 * value for value in predicted["interval"])
    return f"{text}, {low:.1f} to {high:.1f} um (90 %)"


def fail_unless_done(outcome: Mapping[str, Any]) -> None:
    """Raise RunFailed for a summary whose status is a failure; its files are written by then."""
    if outcome["status"] in _ENDS:
        raise RunFailed(_ENDS[outcome["status"]].format(k=outcome["iterations"][-1]["k"]))
