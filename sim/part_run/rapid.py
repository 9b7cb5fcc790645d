"""Rapid moves between the contours of a part: straight lines, by the planner of motion programs."""

import numpy as np

from armside.arrays import Array
from armside.kinematics import Limits, Robot

from ..motion.instructions import Dynamics, MoveL, Program, Speed, Target
from ..motion.planner import straight_timing
from ..motion.timing import PathLimits, Timing

NOWHERE = 1e-6
"""Length of a move that is none [m]."""


def rapid_timing(
    ends: Array, phi: Array, speed: float, path: PathLimits, robot: Robot, limits: Limits
) -> Timing | None:
    """Timing of the arc length of a straight move; None for one that leads nowhere.

    ends: (2, 3) [m], base axes. phi: (6,) [rad], motor angles at its start. speed: [m/s].

    Raises ProgramError for a place out of reach.
    """
    length = float(np.linalg.norm(ends[1] - ends[0]))
    if length < NOWHERE:
        return None
    x, y, z = map(float, ends[1])
    program = Program(
        instructions=(MoveL(to=Target(position=(x, y, z)), speed=Speed(path=speed)),),
        start=tuple(map(float, phi)),
        dynamics=Dynamics(
            path_acceleration=path.acceleration, jerk_time=path.acceleration / path.jerk
        ),
        source="rapid move",
    )
    timing = straight_timing(program, robot, limits)
    return Timing(timing.start, length * timing.state, timing.duration)
