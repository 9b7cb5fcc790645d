"""What a search minimises: the part of the tool's RMS that a design leaves.

Optuna is imported here only where it is used: it takes half a second.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from armside.sim.laser.design import Design
from armside.sim.laser.experiment import Experiment
from armside.sim.tuning.action import Motors
from armside.sim.tuning.rules import Rules
from armside.sim.tuning.sensor import Sees
from armside.sim.tuning.situation import Situation, begin, restarted
from armside.sim.tuning.task import Task, experiment

from ..jobs.workers import cores
from ..shell.interrupts import Stop
from . import study as studies
from .study import WORST

if TYPE_CHECKING:
    import optuna

Item = TypeVar("Item")
Result = TypeVar("Result")

POLL = 0.1
"""[s], between looks for Ctrl-C while threads work."""


class Ratio(NamedTuple):
    """The tool's RMS after learning over that before, as the geometric mean of all episodes.

    Both are WORST once an episode diverged.
    """

    seen: float
    """As the configured sensor sees it."""
    true: float
    """As it was."""


class Episode(NamedTuple):
    """One job of one robot individual, before its first run."""

    task: Task
    experiment: Experiment


def prepare(rules: Rules, seeds: Iterable[int], fixed: dict[str, Any]) -> list[Episode]:
    """The episodes of those seeds.

    fixed: what is not drawn, as the options of `armside.sim.tuning.task.draw`.

    Raises ValueError where a job cannot be done or a seed is sealed.
    """
    imu = Sees(rules.reward).imu
    episodes = []
    for seed in seeds:
        rules.check_seed(seed)
        drawn = rules.draw(np.random.default_rng(seed), fixed)
        episodes.append(Episode(drawn, experiment(rules.robot, rules.nominal, drawn, imu)))
    return episodes


class Objective:
    """What a design leaves of the tool's RMS, in the eyes of the configured sensor.

    The runs before learning are made once; every design then meets the same noise. Use it as a
    context manager: it ends its threads.
    """

    taken = False
    """Another process has taken a trial of this one for dead, and ended it."""

    def __init__(self, rules: Rules, episodes: Sequence[Episode], stop: Stop = Stop()) -> None:
        """Make the first runs. Raises KeyboardInterrupt when `stop` is asked for, as all that
        follows does."""
        self.rules = rules
        self._stop = stop
        self._pool = ThreadPoolExecutor(min(cores(), len(episodes)))
        try:
            self._first = self._each(lambda e: begin(*e, rules.sensor), episodes)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Objective":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __call__(self, trial: "optuna.Trial") -> float:
        """Try a design, and give up where the pruner says so."""
        import optuna

        try:
            return self._tried(trial)
        except optuna.exceptions.UpdateFinishedTrialError:
            self.taken = True
            raise

    def ratios(self, design: Design) -> Iterator[Ratio]:
        """The ratio after each iteration; WORST, and the last, once any episode diverged."""
        situations = [restarted(situation) for situation in self._first]
        for _ in range(self.rules.iterations):
            situations = self._each(lambda s: self.rules.advance(s, design), situations)
            yield self._ratio(situations)
            if any(s.diverged for s in situations):
                return

    def close(self) -> None:
        """Stop the threads, after the runs that they are in."""
        self._pool.shutdown(cancel_futures=True)

    def _tried(self, trial: "optuna.Trial") -> float:
        import optuna

        design = studies.suggest(trial, Motors(self.rules.motors))
        ratio, hopeless = Ratio(1.0, 1.0), False
        for k, ratio in enumerate(self.ratios(design), start=1):
            trial.report(ratio.seen, k)
            going_on = ratio.seen < WORST and k < self.rules.iterations
            hopeless = going_on and trial.should_prune()
            if hopeless:
                break
        trial.set_user_attr(studies.TRUE, ratio.true)
        if hopeless:
            raise optuna.TrialPruned
        return ratio.seen

    def _each(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of each, in order, on the threads."""
        futures = [self._pool.submit(function, item) for item in items]
        self._stop.check()
        while wait(futures, POLL, FIRST_EXCEPTION).not_done:
            self._stop.check()
            if any(future.done() and future.exception() for future in futures):
                break
        return [future.result() for future in futures]

    def _ratio(self, situations: list[Situation]) -> Ratio:
        if any(s.diverged for s in situations):
            return Ratio(WORST, WORST)
        pairs = list(zip(situations, self._first, strict=True))
        return Ratio(
            seen=mean_ratio((s.seen.rms, first.seen.rms) for s, first in pairs),
            true=mean_ratio((s.true.rms, first.true.rms) for s, first in pairs),
        )


def mean_ratio(pairs: Iterable[tuple[float, float]]) -> float:
    """Geometric mean of after over before; WORST where there is none."""
    ratio = float(np.exp(np.mean([np.log(after / before) for after, before in pairs])))
    return ratio if np.isfinite(ratio) else WORST
