"""Servo inputs of a whole run, as arrays known before the run.

The feedback itself, tau = kp (pos - q) + kd (vel - q') + ff, runs inside the physics (the
`dcmotor` controller). What enters it is formed here, arm side, at the physics rate:

    pos = r + u_f        vel = g (r' + u_f')        ff = rigid inverse dynamics of r

where g is the velocity feedforward and u_f the correction after its delay and first-order lag.
u_f does not enter the torque feedforward. ff may contain friction (`armside.sim.robot.drives`);
encoder noise enters as a perturbation of pos and vel.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from armside.arrays import Array, read_only
from armside.ilc.filters import recursion

from .model import RobotModel

VELOCITY_FILTER = 200.0
"""[Hz], of the first-order low-pass behind the difference quotient of an encoder. ESTIMATE."""


@dataclass(frozen=True, kw_only=True)
class Setpoints:
    """Set points (M, n) [rad] and [rad/s] at the physics rate, arm side."""

    position: Array
    velocity: Array


def substeps(timestep: float, log_period: float) -> int:
    """Physics steps per log sample. Raises ValueError unless it is a whole number."""
    ratio = log_period / timestep
    if abs(ratio - round(ratio)) > 1e-9 or round(ratio) < 1:
        raise ValueError(f"log period {log_period} s is not a multiple of the step {timestep} s")
    return round(ratio)


def interpolate(samples: Array, period: float, ratio: int) -> tuple[Array, Array, Array]:
    """Cubic spline through log samples (N, n), one each `period` [s], at rest at both ends.

    Returns value, first and second derivative, each ((N - 1) * ratio + 1, n).
    """
    from scipy.interpolate import CubicSpline

    n = len(samples)
    spline = CubicSpline(np.arange(n) * period, samples, bc_type="clamped")
    t = np.arange((n - 1) * ratio + 1) * (period / ratio)
    return spline(t), spline(t, 1), spline(t, 2)


def correction_path(
    correction: Array, period: float, ratio: int, delay: float, lag: float
) -> Setpoints:
    """Correction at the input of the servo: first-order hold, pure delay, first-order lag.

    With the hold, the derivative after the lag, u_f' = 2 pi lag (u - u_f), is free of impulses.
    correction: (N, n) [rad], u at the log rate; delay in [s], corner frequency of the lag in [Hz].
    """
    shape = ((len(correction) - 1) * ratio + 1, correction.shape[1])
    path = Setpoints(position=np.empty(shape), velocity=np.empty(shape))
    extend_path(path, correction, (0, shape[0]), CorrectionTiming(period, ratio, delay, lag))
    return path


@dataclass(frozen=True)
class CorrectionTiming:
    """Timing of a correction on its way to the servo."""

    period: float
    """[s], between samples of the correction."""
    ratio: int
    """Physics steps in a period."""
    delay: float
    """[s]."""
    lag: float
    """[Hz], corner of the first-order lag."""


def extend_path(
    path: Setpoints, correction: Array, rows: tuple[int, int], timing: CorrectionTiming
) -> None:
    """Write rows first to last (exclusive) of a correction's path; those before are there.

    Row i needs the correction up to the sample after (i h - delay) / period, h the physics step.
    """
    timings = np.array([timing.period, timing.period / timing.ratio, timing.delay])
    out = path.position, path.velocity
    _held_and_lagged(read_only(correction), timings, 2.0 * np.pi * timing.lag, rows, out)


@njit(cache=True, nogil=True)
def _held_and_lagged(
    samples: Array, timing: Array, omega: float, rows: tuple[int, int], out: tuple[Array, Array]
) -> None:  # pragma: no cover - compiled
    """First-order lag x' = omega (signal - x), exact for a signal that is linear between steps."""
    position, velocity = out
    period, step, delay = timing
    n, decay = len(samples), np.exp(-omega * step)
    last = np.empty(samples.shape[1])
    for i in range(max(rows[0] - 1, 0), rows[1]):
        sample = min(max((i * step - delay) / period, 0.0), n - 1.0)
        before = min(int(sample), n - 2)
        weight = sample - before
        for j in range(samples.shape[1]):
            signal = samples[before, j] * (1.0 - weight) + samples[before + 1, j] * weight
            if i == 0:
                position[i, j], velocity[i, j] = signal, 0.0
            elif i >= rows[0]:
                slope = (signal - last[j]) / step
                steady = signal - slope / omega
                x = steady + (position[i - 1, j] - last[j] + slope / omega) * decay
                position[i, j] = x
                velocity[i, j] = omega * (signal - x)
            last[j] = signal


def at_step_end(signal: Array) -> Array:
    """Set points shifted by one step, for feedback that is evaluated at the end of the step."""
    return np.concatenate((signal[1:], signal[-1:]))


def motor_controls(model: RobotModel, position: Array, velocity: Array, torque: Array) -> Array:
    """Control array of the MJCF from arm-side set points (M, n) [rad], [rad/s] and [N m].

    (M, nu): per actuator position [motor rad], velocity [motor rad/s], torque [motor N m].
    """
    gear = model.drives.gear
    controls = np.stack((position * gear, velocity * gear, torque / gear), axis=2)
    return controls.reshape(len(position), -1)


def encoder_perturbation(noise: Array, step: float) -> Array:
    """Speed error [rad/s] by encoder noise (M, n) [rad]: its difference quotient, low-passed."""
    c = np.exp(-2.0 * np.pi * VELOCITY_FILTER * step)
    gain = (1.0 - c) / step
    return recursion(np.array([gain, -gain]), np.array([1.0, -c]), noise)
