"""Learning of a cut as the options of `armside laser` ask, from a twin's correction if they do."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from armside.arrays import Array
from armside.sim.laser.experiment import Experiment, Iteration, prepare
from armside.sim.laser.learning import iterate
from armside.sim.laser.measures import Measure, SetUp
from armside.sim.laser.results import results
from armside.sim.laser.tool_measure import ToolPath

from .earlier import Earlier
from .first_cut import ByTwin, corrected
from .options import LaserCfg
from .specification import cut, measure


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """A cut before its first run."""

    experiment: Experiment
    measure: Measure
    set_up: SetUp
    by_twin: ByTwin | None = None
    earlier: Earlier | None = None

    @classmethod
    def of(cls, experiment: Experiment, measure: Measure) -> "Prepared":
        """Without a twin. Raises ValueError for a robot that the measure cannot serve."""
        set_up = measure.prepare(experiment)
        return cls(experiment=experiment, measure=measure, set_up=set_up)

    def results(self, iterations: list[Iteration]) -> dict[str, Any]:
        """Status, limits and measures of its runs, as `summary.json` has them."""
        of_tool = isinstance(self.measure, ToolPath)
        return results(self.experiment, iterations, of_tool=of_tool)

    @property
    def start(self) -> Array | None:
        """(N, n) [rad], arm side, correction of the first run; None for none."""
        if self.earlier is not None:
            resume = self.earlier.resume
            own = self.earlier.correction(self.experiment.motion)
            return own if resume is None else resume.start
        return None if self.by_twin is None else self.by_twin.start

    def by_twin_of(self, folder: Path) -> "Prepared":
        """The cut with a first run that a twin corrects.

        Raises InputError for a folder without a twin, or one of another robot.
        """
        found = corrected(folder, self.experiment)
        measure = found.around(self.measure, self.experiment)
        return replace(self, by_twin=found, set_up=measure.prepare(self.experiment))

    def iterations(self, count: int) -> Iterator[Iteration]:
        """Iterations k = 0 .. `count`, until done or diverged."""
        resume = None if self.earlier is None else self.earlier.resume
        return iterate(self.experiment, self.set_up, count, start=self.start, resume=resume)

    @property
    def uncorrected(self) -> Iteration | None:
        """The first run without correction, where one was taken over from another experiment."""
        if self.earlier is None or not self.earlier.changed:
            return None
        fresh = prepare(self.experiment.cut, seed=self.experiment.seed)
        return next(iterate(fresh, self.measure.prepare(fresh), 0))


def prepared(cfg: LaserCfg, seed: int) -> Prepared:
    """Everything before the first run but a twin; raises ValueError for what cannot be done."""
    return Prepared.of(prepare(cut(cfg), seed=seed), measure(cfg))


def run(cfg: LaserCfg, seed: int) -> dict[str, Any]:
    """Prepare, run and learn: status, limits and measures, as `results` arranges them.

    With a twin also `predicted`, as `armside laser` has it.
    """
    job = prepared(cfg, seed)
    if cfg.twin is not None:
        job = job.by_twin_of(cfg.twin)
    found = job.results(list(job.iterations(cfg.iterations)))
    return found if job.by_twin is None else found | {"predicted": job.by_twin.predicted}
