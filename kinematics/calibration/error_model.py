"""Error model of a serial arm: every geometric error parameter is a joint of a longer robot.

Base and tool frame are moved by three translations and three rotations each; link i gets errors of
its four Denavit-Hartenberg parameters and Hayati's rotation beta_i about its y-axis, which takes
the place of d where two axes are parallel. The identification Jacobian is then the Jacobian of the
longer robot, in sections that the symbolic toolbox derives and compiles (`error_chain`).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..dh import Joint, Link, Robot
from ..links import standard_links
from .error_chain import BASE, LINK, SIZE, TOOL, Section, joined, sections

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

    def kinematics(self, variables: Array) -> Section:
        """Pose (N, 4, 4) and Jacobian (N, 6, E) of the tool, for variables (N, E)."""
        n, of_section = len(variables), self._of_section
        own = np.tile(self._nominal, (n, 1, 1))
        first = 0
        for i, columns in enumerate(of_section):
            own[:, i, columns] += variables[:, first : first + len(columns)]
            first += len(columns)
        T, J = sections(own.reshape(-1, SIZE))
        T, J = T.reshape(n, -1, 4, 4), J.reshape(n, -1, 6, SIZE)
        parts = enumerate(of_section)
        return joined([Section(T[:, i], J[:, i][:, :, columns]) for i, columns in parts])

    def nominal_pose(self, phi: Array) -> Array:
        """T_base_tool (N, 4, 4) of the robot without errors, at motor angles (N, n)."""
        return self.kinematics(self.variables(phi, np.zeros(len(self.names)))).pose

    @cached_property
    def _links(self) -> tuple[Link, ...]:
        return standard_links(self.robot)

    @cached_property
    def _of_section(self) -> list[list[int]]:
        """Places of the error parameters among those of each section."""
        return [list(one) for one in (*BASE, *[LINK] * len(self._links), *TOOL)]

    @cached_property
    def _nominal(self) -> Array:
        """(S, 6), parameters of the sections of the robot without errors."""
        links = [[*(float(getattr(link, k)) for k in DH), 0.0] for link in self._links]
        out = np.zeros((len(self._of_section), SIZE))
        out[len(BASE) : -len(TOOL), LINK] = links
        return out
