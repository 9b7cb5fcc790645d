"""The objective of a search: the tool's RMS after learning with a design, over that before."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..laser.design import Design
from ..laser.experiment import Experiment
from ..motion.tool_motion import motion_notes
from ..notes import Note, counted
from ..robot.run import cores
from .episode_task import Task
from .rules import Rules
from .situation import Situation, restarted

Item = TypeVar("Item")
Result = TypeVar("Result")

WORST = 1e3
"""Ratio of a design that diverges: no finite one is that bad."""
_EPISODES = "episodes"
POLL = 0.1
"""[s], between two calls of `check` while threads work."""


class Ratio(NamedTuple):
    """RMS of the tool after learning over that before, geometric mean of all episodes.

    By the configured sensor and by ground truth. Both are WORST once an episode diverged.
    """

    measured: float
    true: float
    notes: tuple[Note, ...] = ()
    """Limits that the last run of the episodes touched."""


class Episode(NamedTuple):
    """One job of one robot individual, before its first run."""

    task: Task
    experiment: Experiment


def prepare(rules: Rules, seeds: Iterable[int], fixed: dict[str, Any]) -> list[Episode]:
    """The episodes of those seeds.

    fixed: what is not drawn, as the options of `armside.sim.tuning.episode_task.draw`.

    Raises ValueError where a job cannot be done or a seed is sealed.
    """
    episodes = []
    for seed in seeds:
        rules.check_seed(seed)
        drawn = rules.draw(np.random.default_rng(seed), fixed)
        episodes.append(Episode(*rules.prepared(drawn)))
    return episodes


class Objective:
    """Ratio of a design over the same episodes, with the same noise for every design.

    The runs before learning are made once. A context manager: it ends its threads, which are faster
    than processes here, as rollouts release the interpreter and an episode's models take longer to
    send than an iteration takes to run.
    """

    def __init__(
        self, rules: Rules, episodes: Sequence[Episode], check: Callable[[], None] = lambda: None
    ) -> None:
        """Make the first runs.

        check: called while runs are waited for, here and later; what it raises ends them.
        """
        self.rules = rules
        self._check = check
        self._pool = ThreadPoolExecutor(min(cores(), len(episodes)))
        try:
            self._first = self._each(lambda e: rules.first(*e), episodes)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Objective":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def notes(self) -> list[Note]:
        """Notes of the episodes before learning: of their motions, and of their first runs."""
        each = (
            (*motion_notes(s.experiment.motion, s.experiment.cut.limits), *s.notes)
            for s in self._first
        )
        return counted(each, _EPISODES)

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

    def _each(self, function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """function(item) of each, in order, on the threads."""
        futures = [self._pool.submit(function, item) for item in items]
        self._check()
        while wait(futures, POLL, FIRST_EXCEPTION).not_done:
            self._check()
            if any(future.done() and future.exception() for future in futures):
                break
        return [future.result() for future in futures]

    def _ratio(self, situations: list[Situation]) -> Ratio:
        if any(s.diverged for s in situations):
            return Ratio(WORST, WORST)
        pairs = list(zip(situations, self._first, strict=True))
        measured = mean_ratio((s.measured.rms, first.measured.rms) for s, first in pairs)
        true = mean_ratio((s.true.rms, first.true.rms) for s, first in pairs)
        return Ratio(measured, true, tuple(counted((s.notes for s in situations), _EPISODES)))


def mean_ratio(pairs: Iterable[tuple[float, float]]) -> float:
    """Geometric mean of after over before; WORST where it is not finite."""
    ratio = float(np.exp(np.mean([np.log(after / before) for after, before in pairs])))
    return ratio if np.isfinite(ratio) else WORST
