"""The objective of a search: the tool's RMS after learning with a design, over that before.

After the last update the design is held, as in version 1 of the env, and the worse of the two runs
counts: a design that is best at the budget and grows beyond it is not a good one.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import Any, NamedTuple, TypeVar

import numpy as np

from armside.arrays import Array

from ..instruments.imu import ImuCfg
from ..laser.design import Design
from ..laser.experiment import Experiment
from ..notes import Note, counted
from ..robot.run import cores
from .episode_task import Task
from .rules import HORIZON, Rules
from .situation import Situation, restarted

Item = TypeVar("Item")
Result = TypeVar("Result")

WORST = 1e3
"""Ratio of a design that diverges: no finite one is that bad."""
_EPISODES = "episodes"
POLL = 0.1
"""[s], between two calls of `check` while threads work."""


class Ratio(NamedTuple):
    """RMS of the tool after learning over that before, geometric mean of all episodes, by the
    sensor and by ground truth; WORST once one diverged."""

    measured: float
    true: float
    notes: tuple[Note, ...] = ()
    """Limits that the last run of the episodes touched."""
    logs: tuple[float, ...] = ()
    """Logarithm of `measured` in each episode; empty once one diverged."""


class Episode(NamedTuple):
    """One job of one robot individual, before its first run."""

    task: Task
    experiment: Experiment


def prepare(
    rules: Rules, seeds: Iterable[int], fixed: dict[str, Any], imu: ImuCfg | None = None
) -> list[Episode]:
    """The episodes of those seeds. Raises ValueError where a job cannot be done or one is sealed.

    fixed: what is not drawn, as the options of `draw`. imu: unit at the tool, beside the reward's.
    """
    episodes = []
    for seed in seeds:
        rules.check_seed(seed)
        drawn = rules.draw(np.random.default_rng(seed), fixed)
        episodes.append(Episode(*rules.prepared(drawn, imu)))
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
        self.runs = 0
        """Runs of the robots, without those before learning, which all designs share."""
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
        return counted((s.all_notes for s in self._first), _EPISODES)

    def ratios(self, design: Design) -> Iterator[Ratio]:
        """The ratio after each iteration; WORST, and the last, once any episode diverged."""
        situations = [restarted(situation) for situation in self._first]
        for k in range(1, self.rules.iterations + 1):
            situations = self._run(lambda s: self.rules.advance(s, design), situations)
            if k == self.rules.iterations and not any(s.diverged for s in situations):
                held = self._run(lambda s: self.rules.held(s, design), situations)
                situations = [max(two, key=badness) for two in zip(situations, held, strict=True)]
            yield self._ratio(situations)
            if any(s.diverged for s in situations):
                return

    def criterion(self, design: Design) -> float:
        """Factor by which the error falls, or grows, by the controller's model."""
        return self.rules.criterion(design)

    def ratio(self, design: Design) -> Ratio:
        """The last of `ratios`."""
        *_, last = self.ratios(design)
        return last

    def foreseen(self, design: Design) -> Ratio:
        """The last of `ratios` with two runs of each episode in place of one for each update."""
        return self._ratio(self._each(lambda s: foreseen(self.rules, s, design), self._first))

    def _run(self, run: Callable[[Situation], Situation], at: list[Situation]) -> list[Situation]:
        self.runs += len(at)
        return self._each(run, at)

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

    def _ratio(self, situations: Sequence[Any]) -> Ratio:
        if any(s.diverged for s in situations):
            return Ratio(WORST, WORST)
        pairs = list(zip(situations, self._first, strict=True))
        measured = mean_ratio((s.measured.rms, first.measured.rms) for s, first in pairs)
        true = mean_ratio((s.true.rms, first.true.rms) for s, first in pairs)
        notes = tuple(counted((s.notes for s in situations), _EPISODES))
        logs = (float(np.log(s.measured.rms / first.measured.rms)) for s, first in pairs)
        return Ratio(measured, true, notes, tuple(logs))


def foreseen(rules: Rules, first: Situation, design: Design) -> Situation:
    """The worse of the runs at the end of the budget and at HORIZON, with the corrections that the
    model of the motors predicts from the first run."""
    ends = (rules.iterations, HORIZON)
    return max((rules.held(first, design, until) for until in ends), key=badness)


def badness(situation: Any) -> float:
    """The tool's RMS of a run as measured; infinite where it diverged."""
    rms = situation.measured.rms
    return rms if np.isfinite(rms) and not situation.diverged else np.inf


def mean_ratio(pairs: Iterable[tuple[float, float]]) -> float:
    """Geometric mean of after over before; WORST where it is not finite."""
    ratio = float(np.exp(np.mean([np.log(after / before) for after, before in pairs])))
    return ratio if np.isfinite(ratio) else WORST


def gain(one: Ratio, other: Ratio) -> tuple[float, float, float]:
    """Geometric mean of one design's ratio over another's in the same episodes, and its 95 %
    interval; WORST where the first diverged, 0 where the other did."""
    if not one.logs or not other.logs:
        value = 1.0 if one.logs == other.logs else 0.0 if one.logs else WORST
        return value, value, value
    paired = np.subtract(one.logs, other.logs)
    ratio, low, high = np.exp([paired.mean(), *mean_interval(paired)]).tolist()
    return ratio, low, high


def mean_interval(values: Array, confidence: float = 0.95) -> tuple[float, float]:
    """Interval by Student's t of the mean of values (n,); infinite for one value."""
    from scipy.special import stdtrit

    n, mean = len(values), float(np.mean(values))
    if n < 2:
        return -np.inf, np.inf
    half = stdtrit(n - 1, 0.5 + 0.5 * confidence) * np.std(values, ddof=1) / np.sqrt(n)
    return mean - float(half), mean + float(half)
