"""A part that a robot never cut: uncorrected, by its twin of four cuts, and after learning."""

from pathlib import Path

import numpy as np

from armside.scripts.figures import first_cut
from armside.sim.cell import TOOL_QUATERNION, ToolPose
from armside.sim.laser.specification import Cut
from armside.sim.part.contour_file import rounded
from armside.sim.robot.spread import Drawn

HOUSE = ((-10.0, -6.0), (10.0, -6.0), (10.0, 6.0), (0.0, 9.0), (-10.0, 6.0))
"""[mm], corners of the part in docs/examples/house.toml."""


def draw(_run: Path, file: Path) -> None:
    place = ToolPose((1.6, 0.35, 1.4), TOOL_QUATERNION)
    part = Cut(pose=place, contour=rounded(1e-3 * np.array(HOUSE), 1.5e-3), speed=0.040)
    first_cut.draw(file, part, Drawn(1004), cuts=4)
