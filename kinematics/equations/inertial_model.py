"""Inertial model of a robot: bodies on its links, motors on its joints, gravity."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dh import Robot, checked, symbols_of

if TYPE_CHECKING:
    from ..dh import Scalar

_OFFERED = 1e-4  # relative: how far inside the inequalities an inertia is offered
_SLACK = 1e-9  # relative: how far rounding may take an inertia below the triangle inequality


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body on a link, in the axes of that link's Denavit-Hartenberg frame.

    Mass [kg], centre of mass from the frame's origin [m], and Ixx, Iyy, Izz, Ixy, Ixz, Iyz about
    it [kg m^2] are numbers or SymPy symbols; numbers must be physically consistent.
    """

    mass: "Scalar"
    com: tuple["Scalar", "Scalar", "Scalar"] = (0, 0, 0)
    inertia: tuple["Scalar", "Scalar", "Scalar", "Scalar", "Scalar", "Scalar"] = (0, 0, 0, 0, 0, 0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", checked("mass", self.mass))
        for name, size in (("com", 3), ("inertia", 6)):
            values = tuple(checked(name, value) for value in getattr(self, name))
            if len(values) != size:
                raise ValueError(f"{name} must have {size} values, got {len(values)}")
            object.__setattr__(self, name, values)
        if isinstance(self.mass, int | float) and self.mass < 0:
            raise ValueError(f"mass must be >= 0 kg, got {self.mass}")
        if all(isinstance(value, int | float) for value in self.inertia):
            _check_inertia(self.inertia)


PLACES = (0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)
"""Indices of Ixx, Iyy, Izz, Ixy, Ixz, Iyz in a tensor."""


def tensor_of(inertia: Sequence[Any]) -> list[list[float]]:
    """3 x 3 tensor of a body's inertia."""
    xx, yy, zz, xy, xz, yz = map(float, inertia)
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def _check_inertia(inertia: tuple[Any, ...]) -> None:
    """Principal moments are not negative and none exceeds the sum of the other two."""
    moments = np.linalg.eigvalsh(tensor_of(inertia))
    slack = _SLACK * max(float(np.abs(moments).max()), 1e-12)
    if moments[0] < -slack or moments[2] > moments[0] + moments[1] + slack:
        raise ValueError(
            f"inertia {inertia} is not physically consistent: principal moments "
            f"{moments.tolist()} must be >= 0 and obey the triangle inequality; the nearest: "
            f"{nearest_inertia(inertia)}"
        )


def nearest_inertia(inertia: Sequence[float]) -> list[float]:
    """The inertia (xx, yy, zz, xy, xz, yz) nearest to one that no body has, with six digits."""
    moments, axes = np.linalg.eigh(tensor_of(inertia))
    moments = np.maximum(moments, _OFFERED * np.abs(moments).max())
    missing = max(moments[2] * (1.0 + _OFFERED) - moments[0] - moments[1], 0.0) / 3.0
    tensor = axes @ np.diag(moments + missing * np.array([1.0, 1.0, -1.0])) @ axes.T
    return [float(f"{tensor[place]:.6g}") for place in PLACES]


@dataclass(frozen=True, kw_only=True)
class Motor:
    """One drive, every quantity on the arm side of its gear (motor side times n or n^2).

    Friction: viscous [N m s/rad], coulomb [N m]. Gear: spring k [N m/rad], None where the joint is
    rigid, and damper d [N m s/rad].
    """

    inertia: "Scalar" = 0
    """n^2 J_m [kg m^2]; acts on the motor angle phi_i, so it goes around the coupling."""
    viscous: "Scalar" = 0
    coulomb: "Scalar" = 0
    stiffness: "Scalar | None" = None
    damping: "Scalar" = 0

    def __post_init__(self) -> None:
        for name in ("inertia", "viscous", "coulomb", "stiffness", "damping"):
            if (value := getattr(self, name)) is not None:
                value = checked(name, value)
                if isinstance(value, int | float) and value < 0:
                    raise ValueError(f"{name} must be >= 0, got {value}")
                object.__setattr__(self, name, value)


@dataclass(frozen=True)
class InertialModel:
    """A robot with the inertia of its bodies and its drives; torques are those of the motors."""

    robot: Robot
    bodies: tuple[Body, ...]
    """One for each link, fixed links included."""
    motors: tuple[Motor, ...] = ()
    """One for each joint; massless and without friction by default."""
    gravity: tuple["Scalar", "Scalar", "Scalar"] = (0, 0, -9.82)
    """[m/s^2] in base axes."""

    def __post_init__(self) -> None:
        motors = tuple(self.motors) or (Motor(),) * self.robot.n_joints
        gravity = tuple(checked("gravity", value) for value in self.gravity)
        vars(self).update(bodies=tuple(self.bodies), motors=motors, gravity=gravity)
        for name, expected in (("bodies", len(self.robot.links)), ("motors", self.robot.n_joints)):
            if (given := len(getattr(self, name))) != expected:
                raise ValueError(f"{self.robot.name} needs {expected} {name}, got {given}")
        if len(gravity) != 3:
            raise ValueError(f"gravity must have 3 components, got {len(gravity)}")

    @property
    def key(self) -> str:
        """Text that is equal for two models exactly when all their numbers are equal."""
        return repr((self.robot.key, self.bodies, self.motors, self.gravity))

    @property
    def free_symbols(self) -> frozenset[Any]:
        """Symbols among all parameters, the robot's included."""
        values = [v for motor in self.motors for v in vars(motor).values()]
        values += [v for b in self.bodies for v in (b.mass, *b.com, *b.inertia)]
        return self.robot.free_symbols | symbols_of([*values, *self.gravity])
