"""Error model of a serial arm: every geometric error parameter is a joint of a longer robot.

Base and tool frame are moved by three translations and three rotations each; link i gets errors of
its four Denavit-Hartenberg parameters and Hayati's rotation beta_i about its y-axis, which takes
the place of d where two axes are parallel. The identification Jacobian is then the Jacobian of the
longer robot, a chain of sections: two of the base frame, one of each link, two of the tool frame. A
section is a short robot whose joints are its parameters: a turn and a slide about each axis. Its
pose and Jacobian are derived by the symbolic toolbox and compiled, as one function: nothing is
derived or compiled for a particular arm.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..cache import native_function
from ..compiled import CompiledFunction
from ..dh import Joint, Link, Robot
from ..rigid import standard_links

if TYPE_CHECKING:
    from ..equations.program import StraightLineProgram

_X = (Link(theta=pi / 2, alpha=pi / 2, joint=Joint.FIXED),)
_X_BACK = (Link(alpha=-pi / 2, joint=Joint.FIXED), Link(theta=-pi / 2, joint=Joint.FIXED))
_Y = (Link(alpha=-pi / 2, joint=Joint.FIXED),)
_Y_BACK = (Link(alpha=pi / 2, joint=Joint.FIXED),)
"""Constant links that take the z-axis to x or y, and back."""
_SLIDE, _TURN = Link(joint=Joint.PRISMATIC), Link()
_SECTION = (_TURN, _SLIDE, *_X, _SLIDE, _TURN, *_X_BACK, *_Y, _SLIDE, _TURN, *_Y_BACK)
SIZE = 6
"""Parameters of a section: rz, z, x, rx, y, ry [rad, m], each in the axes of those before it."""
BASE = ((2, 3, 4, 5), (1, 0))
"""Parameters of the sections of the base frame: x, rx, y, ry; then z, rz."""
LINK = (0, 1, 2, 3, 5)
"""theta, d, a, alpha, and Hayati's beta about y."""
TOOL = ((3, 5), (0,))
"""rx, ry; then rz."""


class Section(NamedTuple):
    """Poses (N, 4, 4) and Jacobians (N, 6, m) of a section, in axes of its beginning."""

    pose: Array
    jacobian: Array


@cache
def _function() -> CompiledFunction:
    robot = Robot(_SECTION, name="section with errors")

    def program() -> "StraightLineProgram":
        from ..equations.forward_kinematics import pose_and_jacobian

        return pose_and_jacobian(robot)

    size = 16 + 6 * SIZE
    return native_function("pose_and_jacobian", robot.key, program, (SIZE,), (size,))


def joined(sections: list[Section]) -> Section:
    """Sections one behind the other: pose of the last end and (v, omega) there, first axes."""
    T = np.broadcast_to(np.eye(4), sections[0].pose.shape)
    ends, columns = [], []
    for pose, J in sections:
        R = T[:, :3, :3]
        columns.append(np.concatenate([R @ J[:, :3], R @ J[:, 3:]], axis=1))
        T = T @ pose
        ends.append(T[:, :3, 3])
    for end, J in zip(ends, columns, strict=True):
        J[:, :3] += np.cross(J[:, 3:], (T[:, :3, 3] - end)[:, :, None], axis=1)
    return Section(T, np.concatenate(columns, axis=2))


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
        moving = ((i, link.joint) for i, link in enumerate(self._links, 1) if link.moves)
        return np.array([self.index(f"{kinds[joint]}_{i}") for i, joint in moving])

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
        both = _function()(own.reshape(-1, SIZE))
        T, J = both[:, :16].reshape(n, -1, 4, 4), both[:, 16:].reshape(n, -1, 6, SIZE)
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
