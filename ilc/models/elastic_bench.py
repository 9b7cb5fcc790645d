"""One-axis bench of Chen and Tomizuka: a harmonic drive with friction, disturbances and encoders.

W. Chen, M. Tomizuka, IEEE Trans. Control Systems Technology 22(4), 2014, section IV; inertias and
noise Asian J. Control 16(3), 2014; friction and gains ASME DSCC 2009-2736. Angles: theta of the
motor [rad, motor side], q of the load [rad]; N = 80.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

Response = NDArray[np.complex128]

STEP = 1e-3
"""[s], of controller and log."""
SUBSTEPS = 20
MOTOR_COUNT, LOAD_COUNT = 2.0 * np.pi / 20_000, 2.0 * np.pi / 144_000
"""[rad]."""
KP, KV, KI = 30.0, 0.3, 1.0
"""(kv + ki / s)(s + kp) on the motor angle. DSCC 2009; not repeated in the paper of 2014."""


@dataclass(frozen=True, kw_only=True)
class TwoMass:
    """Linear part: inertias [kg m^2], spring [N m/rad] and damper [N m s/rad], viscous friction."""

    Jm: float = 5.313e-4
    Jl: float = 6.8
    k: float = 3.1e4
    d: float = 47.0
    N: float = 80.0
    viscous: float = 0.001114
    """[N m s/rad], of the motor."""

    def scaled(self, **factors: float) -> "TwoMass":
        """With parameters times these factors."""
        return replace(self, **{name: getattr(self, name) * f for name, f in factors.items()})

    def motor_over_load(self, s: Response) -> Response:
        """theta / q at s, without a torque on the load."""
        return self.N * (self.Jl * s**2 + self.d * s + self.k) / (self.d * s + self.k)

    def torque_over_motor(self, s: Response) -> Response:
        """tau / theta at s: the inverse of P_m."""
        spring = (self.d * s + self.k) / self.N**2
        return self.Jm * s**2 + self.viscous * s + spring * (1.0 - self.N / self.motor_over_load(s))

    def torque_over_load(self, s: Response) -> Response:
        """tau / q at s: the inverse of P_l."""
        return self.torque_over_motor(s) * self.motor_over_load(s)


@dataclass(frozen=True, kw_only=True)
class Individual:
    """What no paper prints: phase of the transmission error, offsets of the encoders."""

    amplitude: float
    """A of A sin(2 theta + phase), torsion [rad, load side]."""
    phase: float = 0.0
    motor_offset: float = 0.0
    load_offset: float = 0.0
    """Fractions of a count."""

    @classmethod
    def drawn(cls, seed: int, amplitude: float) -> "Individual":
        """With phase and offsets of a seed."""
        phase, motor, load = np.random.default_rng(seed).uniform(0.0, (2.0 * np.pi, 1.0, 1.0))
        return cls(amplitude=amplitude, phase=phase, motor_offset=motor, load_offset=load)


@dataclass(frozen=True)
class BenchRun:
    """Signals (N,) every millisecond."""

    motor: Array
    load: Array
    """[rad], as the encoders read them."""
    true_load: Array
    load_rate: Array
    load_acceleration: Array
    """[rad], [rad/s], [rad/s^2], exact."""
    feedback: Array
    """[N m]."""


def reference() -> tuple[Array, Array]:
    """Times (N,) [s] and load angle (N,) [rad]: 0, 0.8, 0 rad at 0.5 rad/s, peaks of 5 rad/s^2.

    Each change of speed takes 0.2 s, around 0.4, 2.0, 2.5 and 4.1 s, with piecewise constant snap.
    """
    time: Array = np.arange(4301, dtype=np.float64) * STEP
    fine: Array = np.arange(43_001, dtype=np.float64) * STEP / 10.0
    acceleration: Array = np.zeros_like(fine)
    for centre, sign in ((0.4, 1.0), (2.0, -1.0), (2.5, -1.0), (4.1, 1.0)):
        x = np.clip((fine - centre) / 0.2 + 0.5, 0.0, 1.0)
        bump = np.where(
            np.abs(x - 0.5) < 0.25, 1.0 - 8.0 * (x - 0.5) ** 2, 8.0 * np.minimum(x, 1.0 - x) ** 2
        )
        acceleration += 5.0 * sign * bump

    def integral(y: Array) -> Array:
        return np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]))]) * STEP / 10.0

    return time, integral(integral(acceleration))[::10]


def run(
    individual: Individual,
    motor_reference: Array,
    feedforward: Array,
    *,
    disturbed: bool = True,
    closed: bool = True,
) -> BenchRun:
    """One run from rest.

    motor_reference: (N,) [rad, motor]. feedforward: (N,) [N m]. disturbed: with the torque of
    0.2 sin(2 pi (t - 3)) N m at the motor from 3 s on, and the sprung lever at the load.
    closed: under feedback.
    """
    linear = TwoMass()
    parameters = np.array([getattr(linear, n) for n in ("Jm", "Jl", "k", "d", "N", "viscous")])
    own = np.array([individual.amplitude, individual.phase])
    offsets = np.array([individual.motor_offset, individual.load_offset])
    gains = np.array([KP, KV, KI]) * closed
    found = _simulator()(
        parameters, own, offsets, gains, motor_reference, feedforward, float(disturbed)
    )
    return BenchRun(*found)


@cache
def _simulator():
    """Compiled at its first use."""
    import numba

    return numba.njit(cache=True)(_simulate)


def _simulate(
    parameters, own, offsets, gains, reference, feedforward, disturbed
):  # pragma: no cover - compiled
    """Signals of `BenchRun`. LuGre friction: 0.1004, 0.1075 N m, 3.951 rad/s, 40 N m/rad."""
    Jm, Jl, k, d, N, viscous = parameters
    A, phase = own
    kp, kv, ki = gains
    n, h = len(reference), STEP / SUBSTEPS
    out = np.empty((6, n))
    theta, omega, q, rate, z = 0.0, 0.0, 0.0, 0.0, 0.0
    still, integral, error_before, acceleration = A * np.sin(phase), 0.0, 0.0, 0.0
    for i in range(n):
        motor = (np.floor(theta / MOTOR_COUNT + offsets[0]) - np.floor(offsets[0])) * MOTOR_COUNT
        load = (np.floor(q / LOAD_COUNT + offsets[1]) - np.floor(offsets[1])) * LOAD_COUNT
        error = reference[i] - motor
        slope = (error - error_before) / STEP + kp * error
        error_before = error
        integral += STEP * slope
        feedback = kv * slope + ki * integral
        out[0, i], out[1, i], out[2, i] = motor, load, q
        out[3, i], out[5, i] = rate, feedback
        for j in range(SUBSTEPS):
            t = i * STEP + j * h
            torque = feedback + feedforward[i]
            lever = 0.0
            if disturbed > 0.0:
                torque += 0.2 * np.sin(2.0 * np.pi * (t - 3.0)) if t > 3.0 else 0.0
                lever = 82.0 * max(q - 0.556, 0.0)
            level = 0.1004 + 0.0071 * np.exp(-((omega / 3.951) ** 2))
            towards = level / 40.0 * (1.0 if omega > 0.0 else -1.0)
            z = towards + (z - towards) * np.exp(-40.0 * abs(omega) / level * h)
            twist = theta / N + A * np.sin(2.0 * theta + phase) - still - q
            twist_rate = omega / N + 2.0 * A * np.cos(2.0 * theta + phase) * omega - rate
            spring = k * twist + d * twist_rate
            omega += h * (torque - 40.0 * z - viscous * omega - spring / N) / Jm
            acceleration = (spring - lever) / Jl
            rate += h * acceleration
            theta += h * omega
            q += h * rate
            if j == 0:
                out[4, i] = acceleration
    return out[0], out[1], out[2], out[3], out[4], out[5]
