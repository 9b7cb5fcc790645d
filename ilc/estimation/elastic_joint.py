"""Load angle of an elastic joint from its motor and inertial sensors: DKF and KKF.

W. Chen, M. Tomizuka, *Comparative study on state estimation in elastic joints*, Asian J. Control
16(3), 2014. DKF: two-mass model driven by the torque. KKF: kinematics driven by the accelerometer,
with theta / N through alpha / (s + alpha) as its angle. Both have biases of the inertial sensors.
"""

from dataclasses import dataclass

import numpy as np

from armside.arrays import Array

from ..models.elastic_bench import MOTOR_COUNT, STEP, BenchRun, TwoMass
from ..models.system import zero_order_hold
from .kalman import Smoother
from .process import Process

TORQUE, ANGLE, GYRO, ACCELEROMETER = 1e-4, 8.225e-9, 2.525e-5, 3.284e-3
"""Variances of the paper: torque [(N m)^2], motor and filtered load angle [rad^2], sensors."""
GYRO_WALK, ACCELEROMETER_WALK = 1e-5, 1e-2
"""Variances of the rates of the biases."""
BIAS = (5e-3, 0.05)
"""Standard deviations of the biases at the start [rad/s], [rad/s^2]. ESTIMATE"""
GYRO_BANDWIDTH = 40.0
"""[Hz], ADXRS150."""
ALPHA = 105.0
"""[rad/s], bandwidth of the motor to load (beta = 1)."""
COULOMB, SMOOTHED = 0.1004, 1.0
"""Friction that the models subtract [N m], over a speed of the motor [rad/s]. ESTIMATE"""


@dataclass(frozen=True)
class Sensors:
    """Readings (N,) every millisecond of one run."""

    torque: Array
    motor: Array
    gyro: Array
    accelerometer: Array


def measured(done: BenchRun, torque: Array, rng: np.random.Generator) -> Sensors:
    """Sensors of a run: noise of the paper's variances, biases, bandwidth of the gyroscope."""
    n, (of_gyro, of_accelerometer) = len(done.motor), rng.normal(0.0, BIAS)
    return Sensors(
        torque=torque,
        motor=done.motor,
        gyro=_lagged(done.load_rate, 2.0 * np.pi * GYRO_BANDWIDTH)
        + of_gyro
        + rng.normal(0.0, GYRO**0.5, n),
        accelerometer=done.load_acceleration
        + of_accelerometer
        + rng.normal(0.0, ACCELEROMETER**0.5, n),
    )


def dkf(model: TwoMass, seen: Sensors, *, gyro: bool = True) -> Array:
    """Load angle (N,) [rad] by the two-mass model; state theta, theta', q, q', biases."""
    m, A = model, np.zeros((6, 6))
    A[0, 1] = A[2, 3] = 1.0
    spring = np.array([m.k / m.N, m.d / m.N, -m.k, -m.d])
    A[1, :4], A[3, :4] = -spring / (m.N * m.Jm), spring / m.Jl
    A[1, 1] -= m.viscous / m.Jm
    B = np.array([[0.0], [1.0 / m.Jm], *[[0.0]] * 4])
    C = np.zeros((3, 6))
    C[0, 0] = C[1, 3] = C[1, 4] = C[2, 5] = 1.0
    C[2] += A[3]
    speed = np.gradient(_lagged(seen.motor, 200.0), STEP)
    driven = seen.torque - COULOMB * np.tanh(speed / SMOOTHED)
    readings = np.column_stack([seen.motor, seen.gyro, seen.accelerometer])
    R = np.diag([ANGLE, GYRO, ACCELEROMETER])
    rows = [0, 1, 2] if gyro else [0, 2]
    starts = [MOTOR_COUNT**2, 0.0, ANGLE / m.N**2, 0.0, BIAS[0] ** 2, BIAS[1] ** 2]
    x = _estimated(A, B, TORQUE, driven, C[rows], R[np.ix_(rows, rows)], readings[:, rows], starts)
    return x[:, 2]


def kkf(model: TwoMass, seen: Sensors, *, gyro: bool = True) -> Array:
    """Load angle (N,) [rad] by kinematics; state filtered angle, q, q', biases."""
    A = np.zeros((5, 5))
    A[0, :2] = -ALPHA, ALPHA
    A[1, 2], A[2, 4] = 1.0, -1.0
    B = np.array([[0.0], [0.0], [1.0], [0.0], [0.0]])
    C = np.zeros((2, 5))
    C[0, 0] = C[1, 2] = C[1, 3] = 1.0
    readings = np.column_stack([_lagged(seen.motor / model.N, ALPHA), seen.gyro])
    rows = [0, 1] if gyro else [0]
    R = np.diag([ANGLE, GYRO])
    starts = [ANGLE, ANGLE, 0.0, BIAS[0] ** 2, BIAS[1] ** 2]
    x = _estimated(
        *(A, B, ACCELEROMETER, seen.accelerometer, C[rows]),
        *(R[np.ix_(rows, rows)], readings[:, rows], starts),
    )
    return x[:, 1]


def _estimated(
    A: Array, B: Array, variance: float, u: Array, C: Array, R: Array, y: Array, start: list[float]
) -> Array:
    """(N, n) filtered states of readings y (N, p) with the input u (N,), held over samples.

    The last two states are biases. The part that u drives is simulated, the rest filtered.
    """
    Ad, Bd = zero_order_hold(A, B, STEP)
    Q = variance * Bd @ Bd.T
    Q[-2:, -2:] += STEP**2 * np.diag([GYRO_WALK, ACCELEROMETER_WALK])
    driven = np.zeros((len(u), len(A)))
    for i in range(len(u) - 1):
        driven[i + 1] = Ad @ driven[i] + Bd[:, 0] * u[i]
    process = Process(A=Ad, Q=Q, C=C, R=R)
    smoother = Smoother(process, np.diag(start), np.ones(len(u), dtype=bool))
    return driven + smoother(y - driven @ C.T).filtered


def _lagged(signal: Array, corner: float) -> Array:
    """Signal through corner / (s + corner), [rad/s], from rest at its first sample."""
    from scipy.signal import lfilter, lfilter_zi

    pole = np.exp(-corner * STEP)
    b, a = np.array([1.0 - pole]), np.array([1.0, -pole])
    return np.asarray(lfilter(b, a, signal, zi=lfilter_zi(b, a) * signal[0])[0])


def chirp() -> Array:
    """Torque (50001,) [N m]: 0.2 N m, 0.5 to 50 Hz in 50 s, quadratic."""
    time = np.arange(50_001) * STEP
    return 0.2 * np.sin(2.0 * np.pi * (0.5 * time + (50.0 - 0.5) / 50.0**2 * time**3 / 3.0))
