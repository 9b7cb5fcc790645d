"""Drive trains as the controller knows them: motors, gears with their transmission error, friction.

`Drives` is read from the custom numerics and actuators of the MJCF.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
from numba import njit

from armside.arrays import Array, read_only
from armside.kinematics.robot_file import GearTerm

from .mjcf import axis_actuators, numeric, scalar


class OwnDrive(Protocol):
    """What a robot's drives do beside what all have: `alien` has such drives."""

    def applied(self, drives: "Drives", load: Array, velocity: Array, time: Array) -> Array | None:
        """(M, n) [N m], arm side, on the motors, None for nothing; load (M, n) [N m] and velocity
        (M, n) [rad/s], arm side, at times (M,) [s] of the commanded motion."""
        ...

    def feedforward(self, drives: "Drives", torque: Array, velocity: Array) -> Array:
        """(M, n) [N m], arm side, in place of the torque feedforward (M, n)."""
        ...

    def commands(self, controls: Array, step: float) -> Array:
        """Controls (M, n, 3) that reach the servo, one each `step` [s]."""
        ...


N_HARMONICS = 4
"""Orders of a gear's transmission error: once and twice the output, once and twice the motor."""
FRICTION_SPEED = 0.02
"""[rad/s], arm side: below it, friction feedforward fades to zero. ESTIMATE."""


@dataclass(frozen=True, kw_only=True)
class Drives:
    """Nominal parameters of the drives, arrays (n,). Motor units: before the gear."""

    gear: Array
    """Gear ratio, motor angle over arm-side angle."""
    kp: Array
    ki: Array
    kd: Array
    """Gains [N m/rad], [N m/(rad s)], [N m s/rad]."""
    torque_limit: Array
    """[N m]."""
    speed_limit: Array
    """[rad/s], arm side."""
    encoder_counts: float
    """Counts per motor revolution; 0 for an ideal encoder."""
    encoder_noise: float
    """[counts rms], white at the rate of the servo."""
    velocity_feedforward: Array
    torque_feedforward: float
    friction_feedforward: float
    """Gains of the feedforward; that of the torque is of rigid computed torque and friction."""
    friction_curve: bool
    """Friction feedforward has Stribeck and viscous friction too, not Coulomb friction alone."""
    coulomb_friction: Array
    static_friction: Array
    stribeck_speed: Array
    viscous_friction: Array
    """[N m], [N m], [rad/s], [N m s/rad]."""
    correction_delay: float
    """[s], before a correction reaches the servo."""
    correction_lag: float
    """[Hz], corner of the first-order lag of a correction."""
    elastic_compensation: float
    """Fraction of the quasi-static elastic deflection that the reference compensates."""
    torque_noise: float
    torque_noise_bandwidth: float
    """Non-repeatable torque, rms relative to the torque limit, and [Hz]."""


def read_drives(mj: mujoco.MjModel) -> Drives:
    """Drives of a robot's model. Raises ModelError for a numeric of the wrong size."""
    actuators = axis_actuators(mj)
    n = len(actuators)
    noise, bandwidth = numeric(mj, "torque_noise", 2)
    gain, bias = mj.actuator_gainprm[actuators], mj.actuator_biasprm[actuators]
    return Drives(
        gear=numeric(mj, "gear_ratio", n),
        kp=gain[:, 4].copy(),
        ki=gain[:, 5].copy(),
        kd=gain[:, 6].copy(),
        torque_limit=mj.actuator_forcerange[actuators, 1].copy(),
        speed_limit=numeric(mj, "speed_limit", n),
        encoder_counts=scalar(mj, "encoder_counts"),
        encoder_noise=scalar(mj, "encoder_noise", 0.0),
        velocity_feedforward=numeric(mj, "velocity_feedforward", n),
        torque_feedforward=scalar(mj, "torque_feedforward", 1.0),
        friction_feedforward=scalar(mj, "friction_feedforward", 0.0),
        friction_curve=bool(scalar(mj, "friction_curve", 0.0)),
        coulomb_friction=bias[:, 3].copy(),
        static_friction=bias[:, 4].copy(),
        stribeck_speed=bias[:, 5].copy(),
        viscous_friction=mj.actuator_damping[actuators].copy(),
        correction_delay=scalar(mj, "correction_delay"),
        correction_lag=scalar(mj, "correction_lag"),
        elastic_compensation=scalar(mj, "elastic_compensation"),
        torque_noise=float(noise),
        torque_noise_bandwidth=float(bandwidth),
    )


def friction_torque(drives: Drives, velocity: Array) -> Array:
    """(M, n) [N m], arm side: friction feedforward at the velocity (M, n) [rad/s] of the reference.

    Coulomb friction; with `friction_curve` also (F_s - F_c) exp(-(v / v_s)^2) and viscous friction.
    """
    gain = drives.friction_feedforward
    fade = np.tanh(velocity / FRICTION_SPEED)
    torque = gain * drives.coulomb_friction * drives.gear * fade
    if not drives.friction_curve:
        return torque
    motor_speed = drives.gear * velocity
    excess = drives.static_friction - drives.coulomb_friction
    stribeck = excess * np.exp(-((motor_speed / drives.stribeck_speed) ** 2))
    return torque + gain * drives.gear * (stribeck * fade + drives.viscous_friction * motor_speed)


@dataclass(frozen=True, kw_only=True)
class GearError:
    """Transmission error of the gears: output angle minus motor angle, arm side.

    epsilon(phi) = sum_h amplitude_h sin(order_h phi + phase_h), each axis.
    """

    amplitude: Array
    order: Array
    phase: Array
    """(n, H) each: [rad] on the arm side, periods per revolution of the output, [rad]."""

    def __call__(self, phi: Array) -> Array:
        """epsilon, shape (M, n) [rad], at arm-side angles phi (M, n)."""
        return _error(read_only(phi), self.amplitude, self.order, self.phase)

    def rate(self, phi: Array, phi_dot: Array) -> Array:
        """Time derivative of epsilon, shape (M, n) [rad/s]."""
        # sin(x + pi/2) = cos(x): the derivative is an error of other amplitudes and phases
        slope, phase = self.amplitude * self.order, self.phase + 0.5 * np.pi
        return _error(read_only(phi), slope, self.order, phase) * phi_dot


_NONE = np.zeros((0, 0))
EXACT = GearError(amplitude=_NONE, order=_NONE, phase=_NONE)
"""Gears without transmission error, of any number of axes."""


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


def gear_error_of(terms: Sequence[GearTerm], n_axes: int) -> GearError:
    """Transmission error with these terms; joints of fewer terms than others have zeros.

    Raises ValueError for a term of a joint that the robot does not have.
    """
    own: list[list[GearTerm]] = [[] for _ in range(n_axes)]
    for term in terms:
        if not 1 <= term.joint <= n_axes:
            raise ValueError(f"gear error of joint {term.joint}: the robot has {n_axes} joints")
        own[term.joint - 1].append(term)
    shape = n_axes, max(1, *map(len, own))
    amplitude, order, phase = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for i, of_joint in enumerate(own):
        for h, term in enumerate(of_joint):
            amplitude[i, h], order[i, h], phase[i, h] = term[2], term[1], term[3]
    return GearError(amplitude=amplitude, order=order, phase=phase)
