"""Transmission error of the gears of an arm: orders, amplitudes, phases, their confidence."""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..recordings.alignment.encoder_motion import EncoderMotion

CONFIDENCE = 1.96
"""Standard deviations of a 95 % interval."""


@dataclass(frozen=True)
class Term:
    """One period of a joint's error: amplitude sin(order phi + phase), output minus motor angle."""

    joint: int
    """From 1."""
    order: float
    """Periods per turn of the output."""
    amplitude: float
    amplitude_deviation: float
    """[rad] on the arm side, and its standard deviation."""
    order_deviation: float
    phase: float
    phase_deviation: float
    """[rad]; the deviation is infinite where the amplitude is not told from zero."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Transmission:
    """epsilon_j(phi) = sum over the terms of joint j, (a sin + b cos)(order phi)."""

    joints: tuple[int, ...]
    """Of each term, from 0."""
    orders: Array
    """(P,)."""
    coefficients: Array
    """(P, 2) [rad], of sin and cos; output minus motor angle."""
    covariance: Array
    """(2 P, 2 P) [rad^2]."""
    order_deviations: Array
    """(P,), standard deviations of the orders."""
    softness: Array | None = None
    """(n,) [s^2], 1 / f_j^2 of the first resonance that amplifies a joint's error; None where the
    arm was taken for rigid."""

    def __call__(self, phi: Array) -> Array:
        """Output minus motor angle (M, n) [rad] at motor angles (M, n)."""
        error = np.zeros_like(phi)
        for joint, order, (a, b) in zip(self.joints, self.orders, self.coefficients, strict=True):
            error[:, joint] += a * np.sin(order * phi[:, joint]) + b * np.cos(order * phi[:, joint])
        return error

    def tool_error(self, motion: EncoderMotion, target: Array) -> Array:
        """(M, 3, n) [m], displacement of a point of the tool by the error of each joint."""
        return motion.point_jacobian(target) * self(motion.phi)[:, None, :]

    @property
    def terms(self) -> list[Term]:
        """Terms by joint, the largest first."""
        each = map(self._term, range(len(self.orders)))
        return sorted(each, key=lambda term: (term.joint, -term.amplitude))

    def _term(self, k: int) -> Term:
        a, b = self.coefficients[k]
        amplitude = float(np.hypot(a, b))
        P = self.covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2]
        along = np.array([a, b]) / amplitude if amplitude else np.array([1.0, 0.0])
        across = np.array([-along[1], along[0]])
        deviation = float(np.sqrt(across @ P @ across))
        return Term(
            joint=self.joints[k] + 1,
            order=float(self.orders[k]),
            amplitude=amplitude,
            amplitude_deviation=float(np.sqrt(along @ P @ along)),
            order_deviation=float(self.order_deviations[k]),
            phase=float(np.arctan2(b, a) % (2.0 * np.pi)),
            phase_deviation=deviation / amplitude if amplitude else np.inf,
        )
