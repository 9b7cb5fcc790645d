"""Ranges and greatest speeds of the motors of a robot."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arguments import real_array


@dataclass(frozen=True, kw_only=True)
class CoupledRange:
    """A bound [rad] on a linear combination of motor angles, such as phi_3 - phi_2."""

    coefficients: tuple[float, ...]
    lower: float
    upper: float


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Ranges of motor angles [rad] on the arm side of the gear, and greatest speeds [rad/s]."""

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    speed: tuple[float, ...]
    coupled: tuple[CoupledRange, ...] = ()

    def __post_init__(self) -> None:
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
            if len(bound.coefficients) != len(self.lower) or not bound.lower < bound.upper:
                needed = f"{len(self.lower)} coefficients and lower below upper"
                raise ValueError(f"a coupled range needs {needed}, got {bound}")

    def contain(self, phi: ArrayLike) -> NDArray[np.bool_]:
        """True for each configuration phi, shape (..., n), that is in every range; shape (...)."""
        phi = real_array("phi", phi, len(self.lower))
        inside = ((phi >= self.lower) & (phi <= self.upper)).all(axis=-1)
        for bound in self.coupled:
            value = phi @ np.asarray(bound.coefficients)
            inside = inside & (value >= bound.lower) & (value <= bound.upper)
        return np.asarray(inside)


def degrees(*values: float) -> tuple[float, ...]:
    """Angles [deg] as a tuple [rad]."""
    return tuple(math.radians(value) for value in values)
