"""Well-known arms that numeric inverse kinematics is measured on."""

from dataclasses import replace
from math import pi

import numpy as np

from armside.kinematics import (
    LARGE_ROBOT,
    LARGE_ROBOT_LIMITS,
    Convention,
    Joint,
    Limits,
    Link,
    Robot,
    compile,
)
from armside.kinematics.dh import degrees

_HALF = pi / 2

# P. Corke, B. Armstrong-Helouvry: A search for consensus among model parameters reported for the
# PUMA 560 robot. IEEE ICRA 1994. Its shoulder is offset by d3.
PUMA_560 = Robot(
    (
        Link(alpha=_HALF),
        Link(a=0.4318),
        Link(d=0.15005, a=0.0203, alpha=-_HALF),
        Link(d=0.4318, alpha=_HALF),
        Link(alpha=-_HALF),
        Link(),
    ),
    name="Puma 560",
)

# R. Paul: Robot manipulators. MIT Press 1981; lengths and limits as in the Robotics Toolbox.
STANFORD_ARM = Robot(
    (
        Link(d=0.412, alpha=-_HALF),
        Link(d=0.154, alpha=_HALF),
        Link(theta=-_HALF, joint=Joint.PRISMATIC),
        Link(alpha=-_HALF),
        Link(alpha=_HALF),
        Link(d=0.263),
    ),
    name="Stanford arm",
)
STANFORD_LIMITS = Limits(
    lower=(*degrees(-170, -170), 0.305, *degrees(-170, -90, -170)),
    upper=(*degrees(170, 170), 1.27, *degrees(170, 90, 170)),
    speed=(1.0,) * 6,  # ESTIMATE; not used
)

# Franka Robotics, robot and interface specifications: Denavit-Hartenberg parameters by Craig.
PANDA = Robot(
    (
        Link(d=0.333),
        Link(alpha=-_HALF),
        Link(d=0.316, alpha=_HALF),
        Link(a=0.0825, alpha=_HALF),
        Link(d=0.384, a=-0.0825, alpha=-_HALF),
        Link(alpha=_HALF),
        Link(d=0.107, a=0.088, alpha=_HALF),
    ),
    convention=Convention.MODIFIED,
    name="Panda",
)
PANDA_LIMITS = Limits(
    lower=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
    upper=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    speed=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
)

# ESTIMATE: axes 4 and 5 are 50 mm apart, as in arms with an offset wrist: no closed form.
OFFSET_WRIST = Robot(
    [replace(link, a=0.05) if i == 4 else link for i, link in enumerate(LARGE_ROBOT.links, 1)],
    offset=LARGE_ROBOT.offset,
    name="LARGE_ROBOT with an offset wrist",
)
CIRCLES = (
    (OFFSET_WRIST, LARGE_ROBOT_LIMITS, (0.2, -0.3, 0.2, 0.3, 0.8, -0.4)),
    (PANDA, PANDA_LIMITS, (0.3, 0.2, 0.1, -1.8, 0.2, 1.9, 0.4)),
)
"""Arms without a closed form, limits, and the configuration [rad] that a circle starts at."""


def circle(robot: Robot, start: tuple[float, ...], count: int = 1000) -> np.ndarray:
    """Poses (count, 4, 4) of a circle of 100 mm diameter in the base's xy plane, no rotation."""
    T = np.repeat(compile(robot).pose(start)[None], count, axis=0)
    t = np.linspace(0, 2 * pi, count)
    T[:, :2, 3] += 0.05 * np.stack([np.cos(t) - 1, np.sin(t)], axis=-1)
    return T
