"""Picture of a first cut by a twin: uncorrected, corrected by the twin, learned on the part."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from armside.sim.laser.experiment import Iteration
from armside.sim.laser.learning import learn
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.specification import Cut
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import commission, plan, recorded

from .laser import circles

UPDATES = 5
"""Learning updates on the part; one run more is made."""
NAMES = (
    "First run, without correction",
    "First run, corrected by the twin",
    "After five learning runs, laser tracker",
)


def draw(file: Path, part: Cut, robot: Drawn, cuts: int) -> None:
    """The same part three times, as the tool truly goes, deviations magnified alike.

    cuts: that the robot's twin is commissioned from.
    """
    known = [
        recorded(replace(c, individual=robot), f"cut-{i}", i) for i, c in enumerate(plan(cuts))
    ]
    found = commission(known).twin.correction(part)
    part = replace(part, individual=robot)
    learned = [*learn(part, measure="tracker", iterations=UPDATES)]
    by_twin = next(learn(part, measure=MotorAngles(), iterations=0, start=found.correction))
    shown: tuple[Iteration, ...] = (learned[0], by_twin, learned[-1])
    tools = [iteration.tool_true for iteration in shown]
    circles(
        file,
        part.curve.point(np.linspace(0.0, part.curve.length, 361)),
        [tool.path for tool in tools],
        rms=[tool.rms for tool in tools],
        maxdev=[tool.maxdev for tool in tools],
        title="A part that the robot never cut before",
        names=NAMES,
        label="tool (ground truth)",
    )
