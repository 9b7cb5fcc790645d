"""The objective of a search for the law that learns from the tool's path, by estimate or tracker.

Of a design gamma and cutoff count: the law inverts a model of the arm. That model has no error to
predict, so a design is held up to HORIZON by runs of the robot.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..estimation.commissioning import Commissioning, OnFault
from ..estimation.tool_law import CUTOFF, ToolLaw
from ..evaluation.tool_error import ToolError
from ..laser.design import Design
from ..laser.experiment import Pass
from ..laser.loop import iterate
from ..laser.tool_measure import Source, ToolOutput, ToolPath
from ..notes import Note
from .objective import Episode, Objective, Ratio, badness
from .rules import HORIZON, Rules
from .situation import Situation, restarted

DEFAULT = Design(gamma=(ToolLaw.gamma,), delta=(0,), cutoff=(CUTOFF,))
"""Gain and least cutoff of `armside laser --measure estimate`; there is no shift."""


def tool_path(source: Source) -> ToolPath:
    """The measure, which uses the assumed springs where an IMU cannot be used."""
    return ToolPath(source=source, commissioning=Commissioning(on_fault=OnFault.GO_ON))


class _Seen(NamedTuple):
    """What a ratio is made of."""

    measured: ToolError
    true: ToolError
    diverged: bool
    notes: tuple[Note, ...]


class ToolObjective(Objective):
    """As `Objective`, of designs of the law that learns from the tool's path."""

    def __init__(
        self,
        rules: Rules,
        episodes: Sequence[Episode],
        check: Callable[[], None] = lambda: None,
        *,
        source: Source,
    ) -> None:
        """source: of the path. The arm is commissioned by a run of its own."""
        super().__init__(rules, episodes, check)
        self._path = tool_path(source)
        try:
            self._outputs = self._each(self._commissioned, self._first)
        except BaseException:
            self.close()
            raise

    def criterion(self, design: Design) -> float:
        """By the model that is inverted the error is that much of the last one."""
        return abs(1.0 - design.gamma[0])

    def ratios(self, design: Design) -> Iterator[Ratio]:
        """As of `Objective`; HORIZON runs of each episode."""
        law = ToolLaw(gamma=design.gamma[0], cutoff=design.cutoff[0])
        every = zip(self._first, self._outputs, strict=True)
        loops = [self._loop(now, *output, law) for now, output in every]
        at_budget: list[_Seen] = []
        for k in range(HORIZON + 1):
            seen = self._each(next, loops)
            self.runs += len(seen) * (k > 0)
            diverged = any(one.diverged for one in seen)
            if k == self.rules.iterations:
                at_budget = seen
            if k == HORIZON and not diverged:
                seen = [max(two, key=badness) for two in zip(seen, at_budget, strict=True)]
            # The last value that is given is that after HORIZON.
            if diverged or k == HORIZON or 0 < k < self.rules.iterations:
                yield self._ratio(seen)
            if diverged:
                return

    def _commissioned(self, situation: Situation) -> tuple[ToolOutput, Pass]:
        experiment = restarted(situation).experiment
        first = experiment.plant.run(np.zeros_like(situation.correction))
        arm = self._path.assumed(experiment)
        return self._path.commissioned(experiment, arm, first), first

    def _loop(
        self, situation: Situation, output: ToolOutput, first: Pass, law: ToolLaw
    ) -> Iterator[_Seen]:
        experiment, measure = restarted(situation).experiment, replace(output.measure, law=law)
        own = replace(output, measure=measure, _validity=[])
        for one in iterate(experiment, lambda _: own, HORIZON, first=first):
            yield _Seen(situation.reading(one.run), one.tool_true, one.diverged, one.notes)
