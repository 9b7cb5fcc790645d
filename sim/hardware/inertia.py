"""Inertias of rigid bodies: checked, rotated, and estimated as uniform cylinders."""

from typing import Any

import numpy as np

from armside.arrays import Array

from .numbers import vector

DENSITY = 2000.0
"""[kg/m^3] of a link: castings of aluminium with motors, gears and cavities. ESTIMATE."""
SMALLEST = 1e-9
"""[kg m^2], a principal moment below which a body counts as a point."""
_SLACK = 1e-9  # relative rounding below the triangle inequality
Six = tuple[float, float, float, float, float, float]


def checked_inertia(where: str, value: Any) -> Six:
    """xx, yy, zz, xy, xz, yz [kg m^2] of three or six numbers of a file.

    Raises ValueError for an inertia that no body has; the message names the field.
    """
    if isinstance(value, list) and len(value) == 3:
        value = [*value, 0, 0, 0]
    if not isinstance(value, list) or len(value) != 6:
        raise ValueError(f"{where} must be 3 or 6 numbers: xx, yy, zz, xy, xz, yz, got {value!r}")
    six = vector(where, value, 6, "kg m^2")
    low, middle, high = np.linalg.eigvalsh(matrix(six)).tolist()  # pyright: ignore
    if low <= 0.0 or high > (low + middle) * (1.0 + _SLACK):
        raise ValueError(
            f"{where} must have principal moments above 0 of which none exceeds the sum of the "
            f"other two, got {low:.4g}, {middle:.4g}, {high:.4g}"
        )
    return six  # pyright: ignore[reportReturnType] - the size is checked


def matrix(six: Six) -> Array:
    """Inertia tensor (3, 3)."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def six_of(tensor: Array) -> Six:
    """xx, yy, zz, xy, xz, yz of a tensor (3, 3)."""
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(tensor[i]) for i in places)  # pyright: ignore[reportReturnType]


def rotated(six: Six, R: Array) -> Six:
    """The inertia in other axes: R (3, 3) from its own to those."""
    return six_of(R @ matrix(six) @ R.T)


def cylinder(mass: float, along: Array) -> tuple[float, float]:
    """Length and radius [m] of a uniform cylinder of that mass [kg] along a vector (3,) [m].

    One as short as wide where the vector is shorter than the cube of that volume.
    """
    volume = mass / DENSITY
    length = max(float(np.linalg.norm(along)), volume ** (1.0 / 3.0))
    return length, float(np.sqrt(volume / (np.pi * length)))


def of_cylinder(mass: float, along: Array) -> Six:
    """Inertia of that cylinder about its middle, in the axes of the vector."""
    length, radius = cylinder(mass, along)
    about, across = mass * radius**2 / 2.0, mass * (3.0 * radius**2 + length**2) / 12.0
    size = float(np.linalg.norm(along))
    u = along / size if size > 1e-9 else np.array([0.0, 0.0, 1.0])
    return six_of(across * np.eye(3) + (about - across) * np.outer(u, u))
