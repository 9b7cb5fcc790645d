"""Error model of a serial arm: every geometric error parameter is a joint of a longer robot.

Base and tool frame are moved by three translations and three rotations each; link i gets errors of
its four Denavit-Hartenberg parameters and Hayati's rotation beta_i about its y-axis, which takes
the place of d where two axes are parallel. The identification Jacobian is then the Jacobian of the
longer robot: derived by the symbolic toolbox, compiled, and kept.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..compiled import CompiledRobot, compile
from ..dh import Joint, Link, Robot
from ..links import standard_links

_X = (Link(theta=pi / 2, alpha=pi / 2, joint=Joint.FIXED),)
_X_BACK = (Link(alpha=-pi / 2, joint=Joint.FIXED), Link(theta=-pi / 2, joint=Joint.FIXED))
_Y = (Link(alpha=-pi / 2, joint=Joint.FIXED),)
_Y_BACK = (Link(alpha=pi / 2, joint=Joint.FIXED),)
"""Constant links that take the z-axis to x or y, and back."""

AXES = ("x", "y", "z")
DH = ("theta", "d", "a", "alpha")


class Parameter(NamedTuple):
    """A geometric error parameter: its name, and whether it is a length [m] or an angle [rad]."""

    name: str
    is_length: bool


@dataclass(frozen=True)
class ErrorModel:
    """A robot of numbers with its error parameters."""

    robot: Robot

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All error parameters, from the base to the tool, in the order of the longer robot."""
        named = []
        for axis in AXES:
            named += [Parameter(f"base_{axis}", True), Parameter(f"base_r{axis}", False)]
        for i in range(1, 1 + len(self._links)):
            named += [Parameter(f"{name}_{i}", name in "da") for name in DH]
            named.append(Parameter(f"beta_{i}", False))
        return (*named, *(Parameter(f"tool_r{axis}", False) for axis in AXES))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    def index(self, name: str) -> int:
        """Place of a parameter. Raises ValueError for a name that does not exist."""
        if name not in self.names:
            raise ValueError(f"Unknown parameter {name!r}. It can be: {', '.join(self.names)}")
        return self.names.index(name)

    @cached_property
    def joints(self) -> NDArray[np.intp]:
        """Place of the parameter that each joint variable is added to: theta_i, or d_i."""
        kinds = {Joint.REVOLUTE: "theta", Joint.PRISMATIC: "d"}
        moving = [(i, link) for i, link in enumerate(self._links, 1) if link.moves]
        return np.array([self.index(f"{kinds[link.joint]}_{i}") for i, link in moving])

    def variables(self, phi: Array, errors: Array) -> Array:
        """Joint variables of the longer robot, (N, E), of motor angles (N, n) and errors (E,)."""
        out = np.tile(errors, (len(phi), 1))
        out[:, self.joints] += self.robot.joint_variables(phi)
        return out

    @cached_property
    def compiled(self) -> CompiledRobot:
        """Pose and Jacobian of the longer robot."""
        return compile(self._longer)

    @cached_property
    def _links(self) -> tuple[Link, ...]:
        return standard_links(self.robot)

    @cached_property
    def _longer(self) -> Robot:
        free = (Link(joint=Joint.PRISMATIC), Link())
        links = [*_X, *free, *_X_BACK, *_Y, *free, *_Y_BACK, *free]
        for link in self._links:
            links += [Link(theta=link.theta), Link(d=link.d, joint=Joint.PRISMATIC)]
            links += [*_X, Link(d=link.a, joint=Joint.PRISMATIC), Link(theta=link.alpha), *_X_BACK]
            links += [*_Y, Link(), *_Y_BACK]
        tool = [*_X, Link(), *_X_BACK, *_Y, Link(), *_Y_BACK, Link()]
        return Robot([*links, *tool], name=f"{self.robot.name} with errors")
