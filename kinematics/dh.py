"""A robot as Denavit-Hartenberg data: links, joint types, coupling, convention; and its limits.

A link is four parameters and a joint type; a robot is its links and the linear map from motor
angles to joint variables. Equations follow from these data: see `symbolic` and `compile`.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from armside.arrays import Array, check_numbers, real_array, shown

if TYPE_CHECKING:
    import sympy

    Scalar = float | sympy.Expr


class Joint(Enum):
    """Type of a joint: its variable is the angle theta, the offset d, or it has none."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    FIXED = "fixed"


class Convention(Enum):
    """Order of the four elementary motions in a link transform A_i.

    STANDARD: Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha), thesis (3.27).
    MODIFIED (Craig): Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d), where a and alpha of
    row i are a_{i-1} and alpha_{i-1} of the textbook.
    """

    STANDARD = "standard"
    MODIFIED = "modified"


def checked(name: str, value: Any) -> "Scalar":
    """A finite number, a SymPy expression, or text of the grammar of Table 4.1."""
    if isinstance(value, str):
        from .expressions.grammar import parse

        return parse(value)
    if isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be a number, a SymPy expression or text, got {value!r}")
    if isinstance(value, Real):
        if not _is_finite(value):
            raise ValueError(f"{name} must be finite, got {str(value)[:40]}")
        return int(value) if isinstance(value, int) else float(value)
    if hasattr(value, "free_symbols") and getattr(value, "is_commutative", False):
        if value.is_number and not (value.is_real and _is_finite(value)):
            raise ValueError(f"{name} must be a finite real number, got {str(value)[:40]}")
        return value  # pyright: ignore[reportReturnType] - SymPy is not imported to ask
    given = shown(value) if np.ndim(value) else repr(value)
    raise TypeError(f"{name} must be a number, a SymPy expression or text, got {given}")


def _is_finite(value: Any) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond the range of floats
        return False


def symbols_of(values: Iterable[Any]) -> frozenset[Any]:
    """Symbols and functions of time in numbers and SymPy expressions."""
    return frozenset().union(*(getattr(value, "free_symbols", ()) for value in values))


@dataclass(frozen=True)
class Link:
    """One row of a Denavit-Hartenberg table. Thesis (4.11).

    The joint variable is added to `theta` of a revolute link and to `d` of a prismatic one.
    Each parameter, theta and alpha [rad], d and a [m], is a number, a SymPy expression, or text
    such as "phi[1](t) - Pi/2".
    """

    theta: "Scalar" = 0
    d: "Scalar" = 0
    a: "Scalar" = 0
    alpha: "Scalar" = 0
    joint: Joint = Joint.REVOLUTE

    def __post_init__(self) -> None:
        if not isinstance(self.joint, Joint):
            names = ", ".join(f"Joint.{joint.name}" for joint in Joint)
            raise TypeError(f"joint must be one of {names}, got {self.joint!r}")
        for name in ("theta", "d", "a", "alpha"):
            object.__setattr__(self, name, checked(name, getattr(self, name)))

    @property
    def moves(self) -> bool:
        """True if the link has a joint variable."""
        return self.joint is not Joint.FIXED


@dataclass(frozen=True, eq=False)
class Robot:
    """Links in order from the base, and the coupling of n motors to n joints. Thesis (4.9)-(4.12).

    joint variables = coupling @ phi + offset, over the moving links, where phi are motor angles
    on the arm side of the gearbox [rad] (or metres for a prismatic joint); the coupling, shape
    (n_joints, n_joints), is the identity by default, and the offset, shape (n_joints,), zero.
    """

    links: tuple[Link, ...]
    coupling: Array
    offset: Array
    convention: Convention = Convention.STANDARD
    name: str = "robot"

    def __init__(
        self,
        links: Sequence[Link],
        coupling: ArrayLike | None = None,
        offset: ArrayLike | None = None,
        convention: Convention = Convention.STANDARD,
        name: str = "robot",
    ) -> None:
        links = tuple(links)
        if not links or not all(isinstance(link, Link) for link in links):
            raise TypeError(f"links must be one or more armside.kinematics.Link, got {links!r}")
        if not isinstance(convention, Convention):
            names = "Convention.STANDARD or Convention.MODIFIED"
            raise TypeError(f"convention must be {names}, got {convention!r}")
        n = sum(link.moves for link in links)
        vars(self).update(links=links, convention=convention, name=name)
        vars(self)["coupling"] = _constant("coupling", coupling, np.eye(n))
        vars(self)["offset"] = _constant("offset", offset, np.zeros(n))
        if n and np.linalg.matrix_rank(self.coupling) < n:
            raise ValueError(f"coupling must be invertible, got\n{self.coupling}")

    @property
    def n_joints(self) -> int:
        """Number of moving links, which is the number of motors."""
        return len(self.offset)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Indices of the moving links."""
        return tuple(index for index, link in enumerate(self.links) if link.moves)

    @cached_property
    def slides(self) -> tuple[bool, ...]:
        """True for each moving link that is prismatic, (n_joints,)."""
        return tuple(self.links[index].joint is Joint.PRISMATIC for index in self.moving)

    @cached_property
    def free_symbols(self) -> frozenset[Any]:
        """Symbols and functions of time in the D-H parameters; empty for a robot of numbers."""
        return symbols_of(v for link in self.links for v in vars(link).values())

    @cached_property
    def key(self) -> str:
        """Text that is equal for two robots exactly when all their data but names are equal."""
        arrays = self.coupling.tolist(), self.offset.tolist()
        return repr((self.links, *arrays, self.convention.value))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Robot) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def joint_variables(self, phi: ArrayLike) -> Array:
        """Joint variables of motor angles phi, shape (..., n_joints). Thesis (4.10)."""
        return real_array("phi", phi, self.n_joints) @ self.coupling.T + self.offset

    def motor_angles(self, q: ArrayLike) -> Array:
        """Motor angles phi of joint variables q, shape (..., n_joints). Inverse of (4.10)."""
        right = real_array("q", q, self.n_joints) - self.offset
        return np.asarray(np.linalg.solve(self.coupling, right[..., None])[..., 0], np.float64)


def _constant(name: str, value: ArrayLike | None, default: Array) -> Array:
    """A read-only array with the shape of the default."""
    array = np.array(default if value is None else value, dtype=np.float64)
    if array.shape != default.shape:
        needed = f"shape {default.shape} for {len(default)} moving links"
        raise ValueError(f"{name} must have {needed}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {array}")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, kw_only=True)
class CoupledRange:
    """A bound [rad] on a linear combination of motor angles, such as phi_3 - phi_2."""

    coefficients: tuple[float, ...]
    lower: float
    upper: float

    def __post_init__(self) -> None:
        check_numbers(self, "coefficients", several=True)
        check_numbers(self, "lower", "upper", nan=True)
        if not (np.isfinite(self.coefficients).all() and np.any(self.coefficients)):
            text = f"finite coefficients that are not all 0, got {self.coefficients}"
            raise ValueError(f"a coupled range needs {text}")
        if not self.lower < self.upper:
            given = f"got {self.lower:g} and {self.upper:g}"
            raise ValueError(f"a coupled range needs lower below upper, {given}")


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Ranges of motor angles [rad] on the arm side of the gear, and greatest speeds [rad/s]."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    speed: tuple[float, ...]
    coupled: tuple[CoupledRange, ...] = ()

    def __post_init__(self) -> None:
        check_numbers(self, "lower", "upper", "speed", several=True, nan=True)
        if not len(self.lower) == len(self.upper) == len(self.speed):
            raise ValueError("lower, upper and speed must have one entry for each motor")
        for axis, (low, high) in enumerate(zip(self.lower, self.upper, strict=True), 1):
            if not low < high:
                got = f"got {low:g} and {high:g} on axis {axis}"
                raise ValueError(f"lower must be below upper, {got}")
        for axis, speed in enumerate(self.speed, 1):
            if not speed > 0.0:
                raise ValueError(f"speed must be > 0, got {speed:g} on axis {axis}")
        for bound in self.coupled:
            if len(bound.coefficients) != len(self.lower):
                needed = f"{len(self.lower)} coefficients"
                raise ValueError(f"a coupled range needs {needed}, got {bound}")

    def contain(self, phi: ArrayLike) -> NDArray[np.bool_]:
        """True for each configuration phi, shape (..., n), that is in every range; shape (...)."""
        phi = real_array("phi", phi, len(self.lower))
        inside = ((phi >= self.lower) & (phi <= self.upper)).all(axis=-1)
        for bound in self.coupled:
            value = phi @ np.asarray(bound.coefficients)
            inside = inside & (value >= bound.lower) & (value <= bound.upper)
        return np.asarray(inside)


class Unit(NamedTuple):
    """Largest size that a quantity of an arm can have, and units that a larger one may be in."""

    most: float
    unit: str
    others: tuple[tuple[str, float], ...]
    """Name, and the factor from it to `unit`."""


_DEGREES, _MILLIMETRES = (("degrees", math.pi / 180.0),), (("millimetres", 1e-3),)
_LENGTH = Unit(20.0, "m", _MILLIMETRES)
_TURN = Unit(2.0 * math.pi, "rad", _DEGREES)
UNITS: Mapping[str, Unit] = {
    "theta": _TURN,
    "alpha": _TURN,
    "d": _LENGTH,
    "a": _LENGTH,
    "range": Unit(6.0 * math.pi, "rad", _DEGREES),
    "slide": _LENGTH,
    "rotor_inertia": Unit(1.0, "kg m^2", (("g cm^2", 1e-7), ("kg cm^2", 1e-4))),
}
"""ESTIMATE, each bound: ranges of wrists end at 455 deg (IRB120: 400, KR 16: 350); arms of 4.7 m
are the longest in factories; the rotors of the large robot have 6e-3 kg m^2 at most."""


def check_unit(where: str, quantity: str, value: float) -> None:
    """Raise ValueError for a number that its unit can never be meant with, with what it would be in
    another. A number that is no quantity of `UNITS` is not looked at."""
    if quantity not in UNITS or abs(value) <= UNITS[quantity].most * (1.0 + 1e-9):
        return
    most, unit, others = UNITS[quantity]
    like = " or ".join(f"{name}: {value * factor:.4g} {unit}" for name, factor in others)
    raise ValueError(f"{where} must be at most {most:.4g} {unit}, got {value:g}; looks like {like}")


def degrees(*values: float) -> tuple[float, ...]:
    """Angles [deg] as a tuple [rad]."""
    return tuple(math.radians(value) for value in values)
