"""Cuts at random places of a robot's reach."""

import numpy as np

from armside import kinematics
from armside.sim.cell import ToolPose
from armside.sim.laser.experiment import prepare
from armside.sim.laser.specification import Cut
from armside.sim.robot_file.find import find_cell

SPEEDS = (0.012, 0.077)
"""[m/s], ends of their range."""
REACH = 0.6
"""Fraction of each motor's range that poses are drawn from."""
_STREAM = 0x17  # of these draws, apart from those of individual and instruments
_MOST_DRAWS = 1000


def random_cut(robot: str, seed: int) -> Cut:
    """A circle at a random pose and speed that the robot reaches: the same for the same seed.

    Raises RuntimeError where none is found.
    """
    from scipy.spatial.transform import Rotation

    cell, rng = find_cell(robot), np.random.default_rng([seed, _STREAM])
    arm = kinematics.compile(cell.robot)
    for _ in range(_MOST_DRAWS):
        T = arm.pose(REACH * rng.uniform(cell.limits.lower, cell.limits.upper))
        quaternion = Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True)
        x, y, z = T[:3, 3].tolist()
        w, a, b, c = quaternion.tolist()
        speed = float(rng.uniform(*SPEEDS))
        cut = Cut(robot=robot, pose=ToolPose((x, y, z), (w, a, b, c)), speed=speed)
        try:
            prepare(cut, seed=seed)
        except ValueError:  # beyond the reach or the limits
            continue
        return cut
    raise RuntimeError(f"no cut of {robot} found in {_MOST_DRAWS} draws")
