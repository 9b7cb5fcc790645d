"""The nominal arm with its IMU as a process for filters: what is estimated, and what disturbs it.

    x = (dq, dq', accelerometer low-pass (6), gyro low-pass (6), tau_d (a), b_a (3), b_g (3))

a is the number of axes, dq the deviation of the arm from what motor angles and springs explain.
It is excited by a torque tau_d in each gear that stands for all that the model lacks, a first-order
process: white torque would reach the accelerometer at once and correlate with its noise. The
sensor's noise passes its low-pass as the signal does, so the low-pass belongs to the process.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.process import Process, sampled_noise

from ..instruments.imu import ImuCfg
from .linearised_arm import LinearisedArm

_BUTTERWORTH_DAMPING = np.sqrt(0.5)


TWIST = 6e-5
"""Typical twist of a gear under the inertial loads of a cut [rad]."""
FRACTION = 0.05
"""Standard deviation of tau_d over stiffness times twist, of an arm whose springs are known."""
CORNER = 20.0
"""Corner frequency of tau_d's spectrum [Hz]."""
BIAS_WALK = 1e-3
"""[m/s^2/sqrt(s)] and [rad/s/sqrt(s)] / 10."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmFilter:
    """Continuous matrices; `sampled` makes a process of them."""

    arm: LinearisedArm
    imu: ImuCfg
    torque: Array
    """(a,) [N m], standard deviation of tau_d."""
    A: Array
    """(m, m)."""
    intensity: Array
    """(m, m), of the white noise that drives it."""
    C: Array
    """(6, m): accelerometer and gyro."""

    @property
    def n_free(self) -> int:
        return self.arm.n_free

    @property
    def tool(self) -> Array:
        """(6, m), displacement and rotation of the tool for the state."""
        T = np.zeros((6, len(self.A)))
        T[:, : self.n_free] = self.arm.tool_jacobian
        return T

    def sampled(self, step: float) -> Process:
        """Between IMU samples that are step [s] apart."""
        A, Q = sampled_noise(self.A, self.intensity, step)
        return Process(A=A, Q=Q, C=self.C, R=self.reading_covariance)

    @property
    def reading_covariance(self) -> Array:
        """(6, 6), of rounding to counts; at least a hundredth of the noise, to keep digits."""
        triads = self.imu.accelerometer, self.imu.gyroscope
        noise = [t.noise_density * np.sqrt(t.bandwidth) for t in triads]
        counts = [t.resolution / np.sqrt(12.0) for t in triads]
        floors = [max(count, 0.05 * sd) for count, sd in zip(counts, noise, strict=True)]
        return np.diag(np.repeat([floor**2 for floor in floors], 3))


def arm_filter(arm: LinearisedArm, imu: ImuCfg, fraction: float = FRACTION) -> ArmFilter:
    """The process of one arm and one kind of IMU; `fraction` as `FRACTION`."""
    n = arm.n_free
    m = 2 * n + 12
    bias = m + len(arm.axes)
    size = bias + 6
    A, W = np.zeros((2, size, size))
    A[: 2 * n, : 2 * n], _ = arm.dynamics()
    A[n : 2 * n, m:bias] = np.linalg.inv(arm.mass)[:, arm.axes]
    A[m:bias, m:bias] = -2.0 * np.pi * CORNER * np.eye(len(arm.axes))

    # Accelerometer: J q'' + (rotated gravity) q; gyro: J q'.
    from_state = arm.imu_jacobian[:3] @ A[n : 2 * n]
    from_state[:, :n] += arm.imu_gravity
    turning = np.zeros((3, size))
    turning[:, n : 2 * n] = arm.imu_jacobian[3:]
    for k, (triad, ideal) in enumerate(((imu.accelerometer, from_state), (imu.gyroscope, turning))):
        low, rate = np.split(np.arange(2 * n + 6 * k, 2 * n + 6 * k + 6), 2)
        omega = 2.0 * np.pi * triad.bandwidth
        A[low, rate] = 1.0
        A[rate] = omega**2 * ideal
        A[rate, low] -= omega**2
        A[rate, rate] -= 2.0 * _BUTTERWORTH_DAMPING * omega
        # A one-sided density d^2 is a two-sided intensity d^2 / 2.
        W[rate, rate] = omega**4 * triad.noise_density**2 / 2.0

    torque = fraction * TWIST * arm.stiffness
    W[range(m, bias), range(m, bias)] = 2.0 * (2.0 * np.pi * CORNER) * torque**2
    walk = np.repeat([BIAS_WALK, 0.1 * BIAS_WALK], 3) ** 2
    W[range(bias, size), range(bias, size)] = walk
    C = np.zeros((6, size))
    C[range(6), 2 * n + np.array([0, 1, 2, 6, 7, 8])] = 1.0
    C[range(6), range(bias, size)] = 1.0
    return ArmFilter(arm=arm, imu=imu, torque=torque, A=A, intensity=W, C=C)
