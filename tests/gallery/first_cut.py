"""A part that a robot never cut: uncorrected, by its twin of four cuts, and after learning."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from armside.scripts.figures.laser import circles
from armside.sim.cell import TOOL_QUATERNION, ToolPose
from armside.sim.laser.loop import learn
from armside.sim.laser.measures import MotorAngles
from armside.sim.laser.specification import Cut
from armside.sim.part.contour_file import rounded
from armside.sim.robot.spread import Drawn
from armside.sim.twin.commission import commission, plan, recorded

LINE = ""
SEED = "1004"
HOUSE = ((-10.0, -6.0), (10.0, -6.0), (10.0, 6.0), (0.0, 9.0), (-10.0, 6.0))
"""[mm], corners of the part in docs/examples/house.toml."""
ROBOT = Drawn(int(SEED))
CUTS = 4
"""That the robot's twin is commissioned from."""
UPDATES = 5
"""Learning updates on the part; one run more is made."""
NAMES = (
    "First run, without correction",
    "First run, corrected by the twin",
    "After five learning runs, laser tracker",
)


def draw(_run: Path, file: Path) -> list[np.ndarray]:
    """The same part three times, as the tool truly goes, deviations magnified alike."""
    place = ToolPose((1.6, 0.35, 1.4), TOOL_QUATERNION)
    part = Cut(pose=place, contour=rounded(1e-3 * np.array(HOUSE), 1.5e-3), speed=0.040)
    known = [
        recorded(replace(c, individual=ROBOT), f"cut-{i}", i) for i, c in enumerate(plan(CUTS))
    ]
    found = commission(known).twin.correction(part)
    part = replace(part, individual=ROBOT)
    learned = [*learn(part, measure="tracker", iterations=UPDATES)]
    by_twin = next(learn(part, measure=MotorAngles(), iterations=0, start=found.correction))
    tools = [iteration.tool_true for iteration in (learned[0], by_twin, learned[-1])]
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
    return [tool.path for tool in tools]
