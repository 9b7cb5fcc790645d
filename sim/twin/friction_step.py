"""Friction that a change of the motors' motion brings with it, and the correction that pays for it.

A linear law takes friction for a disturbance that repeats. Where a motor reverses it does not: the
motion that the law asks for has its friction elsewhere, and learning creeps. Inside a twin friction
is known: LuGre, as in the physics,

    z' = v - s0 |v| z / g(v)        g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2)        F = s0 z + s1 z'

The law's step is completed by the correction whose torque is F(new motion) - F(old motion).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array
from armside.ilc.laws.model_based import RegularisedInverse, tapered
from armside.ilc.models.system import Complex

from ..estimation.arm_plant import ArmPlant
from ..robot.mjcf import axis_actuators
from ..robot.model import RobotModel
from ..robot.recording import Recording

_COULOMB, _STATIC, _STRIBECK = 3, 4, 5
_BRISTLE, _BRISTLE_DAMPING = 5, 6


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionStep:
    """Step of a linear law, completed by the friction of the motion that it asks for."""

    law: RegularisedInverse
    plant: ArmPlant
    robot: RobotModel
    """The twin that was run."""

    def __call__(self, correction: Array, error: Array, run: Recording) -> Array:
        """Next correction (N, 6) [rad], from a run with the last one and the tool's error."""
        n = len(correction)
        learned = self.law(correction, error)
        omega = 2.0 * np.pi * np.fft.rfftfreq(2 * n)
        moved = _filtered(self.plant.motor_response(omega), learned - correction)
        extra = self._friction(run, moved)
        paid = self.law.Q(omega)[:, None, None] * self.plant.torque_response(omega)
        return learned + _filtered(paid, extra)

    def _friction(self, run: Recording, moved: Array) -> Array:
        """(N, 6) [N m], arm side: change of friction where motors move by `moved` (N, 6) more."""
        truth, gear = run.truth, self.robot.drives.gear
        step = float(truth.time[1])
        every = round(float(run.time[1]) / step)
        fine = np.empty_like(truth.gear_angle)
        for j in range(fine.shape[1]):
            fine[:, j] = np.interp(truth.time, run.time, moved[:, j])
        old = np.gradient(truth.gear_angle, step, axis=0) * gear
        new = old + np.gradient(fine, step, axis=0) * gear
        constants = friction_constants(self.robot)
        change = gear * (lugre(new, step, constants) - lugre(old, step, constants))
        box = np.ones(every) / every
        smooth = [np.convolve(column, box, mode="same")[::every] for column in change.T]
        return np.column_stack(smooth)


def friction_constants(robot: RobotModel) -> Array:
    """(5, 6): s0, s1, Fc, Fs [motor N m] and vs [motor rad/s] of each drive."""
    mj, axes = robot.mj, axis_actuators(robot.mj)
    return np.stack(
        (
            mj.actuator_dynprm[axes, _BRISTLE],
            mj.actuator_dynprm[axes, _BRISTLE_DAMPING],
            mj.actuator_biasprm[axes, _COULOMB],
            mj.actuator_biasprm[axes, _STATIC],
            mj.actuator_biasprm[axes, _STRIBECK],
        )
    )


@njit(cache=True, nogil=True)
def lugre(velocity: Array, step: float, constants: Array) -> Array:  # pragma: no cover - compiled
    """Friction (M, 6) [N m] at motor speeds (M, 6) [rad/s] from rest, exact for constant speed."""
    force = np.empty_like(velocity)
    for j in range(velocity.shape[1]):
        s0, s1, coulomb, static, stribeck = constants[:, j]
        z = 0.0
        for i in range(velocity.shape[0]):
            v = velocity[i, j]
            g = coulomb + (static - coulomb) * np.exp(-((v / stribeck) ** 2))
            rate = s0 * abs(v) / g
            slope = v - rate * z
            force[i, j] = s0 * z + s1 * slope
            if rate * step > 1e-9:
                z += slope * (1.0 - np.exp(-rate * step)) / rate
            else:
                z += slope * step
    return force


def _filtered(response: Complex, signal: Array) -> Array:
    n = len(signal)
    spectrum = np.fft.rfft(tapered(signal), axis=0)
    moved = (response @ spectrum[:, :, None])[:, :, 0]
    return np.fft.irfft(moved, 2 * n, axis=0)[:n]
