"""Transmission error of gears: what the output does not follow of the input."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array


@dataclass(frozen=True, kw_only=True)
class GearError:
    """Arm-side motor angle minus what the gear makes of it.

    epsilon(phi) = sum_h amplitude_h sin(order_h phi + phase_h), each axis.
    """

    amplitude: Array
    """(6, H) [rad], arm side."""
    order: Array
    """(6, H), periods per turn of the output."""
    phase: Array
    """(6, H) [rad]."""

    def __call__(self, phi: Array) -> Array:
        """epsilon, shape (M, 6) [rad], at arm-side angles phi (M, 6)."""
        return _error(np.ascontiguousarray(phi), self.amplitude, self.order, self.phase)

    def rate(self, phi: Array, phi_dot: Array) -> Array:
        """Its time derivative, shape (M, 6) [rad/s]."""
        # sin(x + pi/2) = cos(x): the derivative is an error of other amplitudes and phases
        slope = _error(
            np.ascontiguousarray(phi),
            self.amplitude * self.order,
            self.order,
            self.phase + 0.5 * np.pi,
        )
        return slope * phi_dot


EXACT = GearError(amplitude=np.zeros((6, 0)), order=np.zeros((6, 0)), phase=np.zeros((6, 0)))
"""Of gears without one."""


@njit(cache=True, nogil=True)
def _error(phi: Array, amplitude: Array, order: Array, phase: Array) -> Array:  # pragma: no cover
    of_sine, of_cosine = amplitude * np.cos(phase), amplitude * np.sin(phase)
    error = np.zeros_like(phi)
    for i in range(phi.shape[0]):
        for j in range(phi.shape[1]):
            s = c = 0.0
            for h in range(order.shape[1]):
                if h > 0 and order[j, h] == 2.0 * order[j, h - 1]:
                    s, c = 2.0 * s * c, 1.0 - 2.0 * s * s  # of twice the angle
                else:
                    s, c = np.sin(order[j, h] * phi[i, j]), np.cos(order[j, h] * phi[i, j])
                error[i, j] += of_sine[j, h] * s + of_cosine[j, h] * c
    return error
