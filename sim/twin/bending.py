"""Elasticity of the links, which the robot's file does not have: further hinges of a twin.

A real structure bends everywhere. Hinges across each link in its middle stand for it, with
compliances that are found; whatever else bends is left over, as in any model.
"""

from ..robot.individual import HiddenHinge, with_hinges
from ..robot.model import RobotModel

_DAMPING_TIME = 2e-4
"""Damping over stiffness [s], as for the hinges of the file."""

Vector = tuple[float, float, float]


def _across(body: str, axis: Vector, middle: Vector, stiffness: float) -> HiddenHinge:
    return HiddenHinge(
        body=body,
        axis=axis,
        position=middle,
        stiffness=stiffness,
        damping=_DAMPING_TIME * stiffness,
    )


BENDING = (
    _across("lower_arm", (1.0, 0.0, 0.0), (0.0, 0.0, 0.54), 2e7),
    _across("lower_arm", (0.0, 1.0, 0.0), (0.0, 0.0, 0.54), 2e7),
    _across("tube", (0.0, 1.0, 0.0), (0.57, 0.0, 0.0), 6e6),
    _across("tube", (0.0, 0.0, 1.0), (0.57, 0.0, 0.0), 6e6),
    _across("tilt", (0.0, 0.0, 1.0), (0.1, 0.0, 0.0), 3e6),
)
"""Stiffness [N m/rad]: five times that of the gears beside them. ESTIMATE; the compliance is
identified with a standard deviation as large as this."""


def with_bending(design: RobotModel) -> RobotModel:
    """Design whose links bend. Raises ModelError for a robot that lacks one of the links."""
    return with_hinges(design, BENDING, "struct_bending")
