"""Compensation of IMU readings for gravity, mounting error and biases."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armside.arrays import Array

from ..instruments.imu import from_vector

GRAVITY = np.array([0.0, 0.0, 9.82])
"""Specific force at rest, base axes [m/s^2]. Thesis (5.2)."""


def to_base(R_base_imu: Array, vector: Array) -> Array:
    """Vectors (K, 3) of the IMU frame in base axes. Thesis (5.3)."""
    return np.einsum("kij,kj->ki", R_base_imu, vector)


def to_imu(R_base_imu: Array, vector: Array) -> Array:
    """Vectors (K, 3) of base axes in the IMU frame."""
    return np.einsum("kji,kj->ki", R_base_imu, vector)


def mean_removed(vector: Array, rest: NDArray[np.bool_]) -> Array:
    """Vectors minus their mean over the samples at rest: the offset correction of thesis 5.1.1."""
    if not rest.any():
        raise ValueError("offsets need samples at rest, there are none")
    return vector - vector[rest].mean(axis=0)


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Constant errors of a mounted IMU: reading = R_site_imu^T @ ideal + bias; R (3, 3), biases
    (3,) [m/s^2] and [rad/s]."""

    R_site_imu: Array
    accelerometer_bias: Array
    gyroscope_bias: Array

    def corrected(self, acceleration: Array, angular_velocity: Array) -> tuple[Array, Array]:
        """Readings (K, 3) of an ideal IMU at the site."""
        return (
            (acceleration - self.accelerometer_bias) @ self.R_site_imu.T,
            (angular_velocity - self.gyroscope_bias) @ self.R_site_imu.T,
        )


MOUNTING = np.deg2rad(1.0)
ACCELEROMETER_BIAS = 0.02
GYROSCOPE_BIAS = np.deg2rad(1.0)
"""Standard deviations of mounting error [rad] and biases [m/s^2], [rad/s] before the fit. They
weight the residual that a motion cannot separate into tilt and bias."""
ACCELERATION = 0.1
ANGULAR_VELOCITY = 0.02
"""Of one reading about its prediction [m/s^2], [rad/s]: vibration more than noise."""


def calibrate(
    acceleration: Array, angular_velocity: Array, ideal_force: Array, ideal_rate: Array
) -> Calibration:
    """Estimate mounting error and biases from readings and ideal readings (K, 3).

    The ideal specific force R_base_imu^T (a + g) uses the actual orientation of every sample, so
    gravity separates a mounting error from a bias as soon as the tool rotates. Maximum a
    posteriori by Gauss-Newton: reading = R^T ideal + b, R <- R exp(delta), where

        d(R^T f) = (R^T f) x delta
    """
    R, biases, scale = np.eye(3), np.zeros(6), (ACCELERATION, ANGULAR_VELOCITY)
    sigma = np.repeat([MOUNTING, ACCELEROMETER_BIAS, GYROSCOPE_BIAS], 3)
    sensors = (acceleration, ideal_force), (angular_velocity, ideal_rate)
    for _ in range(4):
        # Rotation vector of a small rotation, to third order [rad].
        vector = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        information, score = np.diag(sigma**-2), -np.concatenate([vector, biases]) / sigma**2
        for sensor, (reading, ideal) in enumerate(sensors):
            rotated = ideal @ R
            bias = slice(3 * sensor, 3 * sensor + 3)
            residual = (reading - rotated - biases[bias]) / scale[sensor]
            J = np.zeros((len(reading), 3, 9))
            J[:, :, :3] = cross_matrices(rotated) / scale[sensor]
            J[:, :, 3 + 3 * sensor : 6 + 3 * sensor] = np.eye(3) / scale[sensor]
            information = information + np.einsum("kia,kib->ab", J, J)
            score = score + np.einsum("kia,ki->a", J, residual)
        step = np.linalg.solve(information, score)
        R, biases = R @ from_vector(step[:3]), biases + step[3:]
    return Calibration(R_site_imu=R, accelerometer_bias=biases[:3], gyroscope_bias=biases[3:])


def cross_matrices(v: Array) -> Array:
    """Cross-product matrices (K, 3, 3) of vectors (K, 3)."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
