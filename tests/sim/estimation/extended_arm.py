"""The arm's full extended Kalman filter: its whole motion is the state, relinearised each step.

    x = (q, q', accelerometer low-pass (6), gyro low-pass (6), tau_d (a), b_a (3), b_g (3))

Mass, gravity and velocity forces are those of the nominal arm at the estimate; the readings and
their gradients are the toolbox's measurement equation. The deviation form linearises once, this
filter in each step: the two agree where a cut is small, and this one is the reference.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from armside import kinematics
from armside.arrays import Array
from armside.ilc.estimation.process import exponential, sampled_noise
from armside.ilc.filters import ZeroPhaseButterworth
from armside.kinematics.robots import IMU_LINKS
from armside.sim.estimation.arm_filter import ArmFilter, arm_filter
from armside.sim.estimation.estimator import ToolEstimator
from armside.sim.estimation.imu_health import REST
from armside.sim.estimation.linearised_arm import at_rest
from armside.sim.estimation.rigid_motion import ENCODER_FILTER
from armside.sim.instruments.imu import ImuSamples

Step = Callable[[int, Array], tuple[Array, Array]]
"""(i, x) to the state at i + 1 and its Jacobian (n, n)."""
Measurement = Callable[[int, Array], tuple[Array, Array]]
"""(i, x) to the measurement at i, (p,), and its Jacobian (p, n)."""


@dataclass(frozen=True, eq=False)
class ExtendedResult:
    """Filtered and smoothed states (N, n), innovations (N, p) and covariances (N, n, n), (N, p, p).

    Innovations are NaN where the measurement is missing.
    """

    filtered: Array
    filtered_covariance: Array
    smoothed: Array
    innovation: Array
    innovation_covariance: Array


def extended(
    step: Step,
    measurement: Measurement,
    y: Array,
    Q: Array,
    R: Array,
    start: Array,
    start_covariance: Array,
) -> ExtendedResult:
    """Extended Kalman filter forwards, then fixed-interval smoother backwards (de Jong 1989).

    y: (N, p), NaN where a measurement is missing, such as between slower samples.
    """
    n_samples, n, p = len(y), len(start), y.shape[1]
    filtered, weighted = np.zeros((2, n_samples, n))
    covariance, blind, transition = np.empty((3, n_samples, n, n))
    innovation, S_all = np.full((n_samples, p), np.nan), np.zeros((n_samples, p, p))
    x, P = start.copy(), start_covariance.copy()
    for i in range(n_samples):
        blind[i] = np.eye(n)
        seen = np.flatnonzero(np.isfinite(y[i]))
        if seen.size:
            expected, C = measurement(i, x)
            channels = np.ix_(seen, seen)
            C, R_seen, e = C[seen], R[channels], y[i, seen] - expected[seen]
            S = C @ P @ C.T + R_seen
            K = np.linalg.solve(S, C @ P).T
            innovation[i, seen], S_all[i][channels] = e, S
            blind[i], weighted[i] = np.eye(n) - K @ C, C.T @ np.linalg.solve(S, e)
            x = x + K @ e
            P = blind[i] @ P @ blind[i].T + K @ R_seen @ K.T
        filtered[i], covariance[i] = x, P
        x, transition[i] = step(i, x)
        P = transition[i] @ P @ transition[i].T + Q
        P = 0.5 * (P + P.T)
    smoothed, r = np.empty_like(filtered), np.zeros(n)
    for i in range(n_samples - 1, -1, -1):  # as in `kalman.Smoother`
        ahead = r @ transition[i]
        smoothed[i] = filtered[i] + covariance[i] @ ahead
        r = weighted[i] + ahead @ blind[i]
    return ExtendedResult(filtered, covariance, smoothed, innovation, S_all)


START_TORQUE = 1e-3
"""Standard deviation of tau_d at the start, relative to its own: the arm starts at rest, and a
constant error of the rest is none of a cut's."""
STEP = 0.0025
"""Step of the filter [s]; divides the period of the log and of a 100 Hz IMU as nearly as its clock
allows: a reading is taken at the step nearest to it, and moved there along its slope."""


def start_covariance(model: ArmFilter) -> Array:
    """(m, m) at rest before the cut."""
    P, imu = np.zeros(len(model.A)), model.imu
    n, m = model.n_free, 2 * model.n_free + 12
    P[:n] = (1e-7) ** 2  # [rad]: the deflected arm starts where the arm is
    P[n : 2 * n] = (1e-6) ** 2
    for k, triad in enumerate((imu.accelerometer, imu.gyroscope)):
        low, noise = 2 * n + 6 * k, triad.noise_density * np.sqrt(triad.bandwidth)
        P[low : low + 3] = noise**2
        P[low + 3 : low + 6] = (noise * 2.0 * np.pi * triad.bandwidth) ** 2
    P[m:-6] = (model.torque * START_TORQUE) ** 2
    P[-6:-3] = (10.0 * imu.accelerometer.bias + 9.82 * 0.05) ** 2
    P[-3:] = (10.0 * imu.gyroscope.bias + 1e-3) ** 2
    return np.diag(P)


@dataclass(frozen=True, eq=False)
class ExtendedEstimate:
    """The tool by the full filter and smoother."""

    time: Array
    """(N,) [s], every STEP."""
    filtered: Array
    """(N, 3) [m], displacement from the first sample."""
    smoothed: Array


class ExtendedArm:
    """Full filter and smoother on the same arm, noise and parameters as a `ToolEstimator`.

    Gears are linear springs here.
    """

    def __init__(self, known: ToolEstimator, robot: kinematics.Robot) -> None:
        """robot: D-H description of the arm, whose free joints are its axes, tool at its end."""
        self.known, self.model = known, known.models[0]
        gears = self.model.arm
        self._arm = known.arm.with_springs(gears.stiffness, gears.damping)
        assert self.model.n_free == robot.n_joints
        self._motion_of = known.arm.motion
        self._data = self._motion_of.data()
        self._tool = kinematics.compile(robot)
        with_imu = replace(robot, links=(*robot.links, *IMU_LINKS), name=f"{robot.name} with IMU")
        self._sensor = kinematics.compile_measurement(with_imu)

    def __call__(self, time: Array, motor_angle: Array, samples: ImuSamples) -> ExtendedEstimate:
        """The tool in one run: log (N,), (N, a) and IMU samples."""
        from scipy.interpolate import CubicSpline

        model = self.model
        smooth = ZeroPhaseButterworth(ENCODER_FILTER, float(time[1] - time[0]))(motor_angle)
        fine: Array = np.arange(0.0, float(time[-1]) + 1e-9, STEP)
        spline = CubicSpline(time, smooth, bc_type="clamped")
        inputs = np.hstack((spline(fine), spline(fine, 1)))
        slopes = np.diff(inputs, axis=0, append=inputs[-1:]) / STEP
        y = self._on_steps(fine, samples)
        n, start = model.n_free, np.zeros(len(model.A))
        start[:n] = at_rest(self._arm, inputs[0, :n])
        _, reading, _ = self._motion(start, inputs[0])
        start[2 * n : 2 * n + 3] = reading[:3]
        start[-6:] = np.nanmean(y[fine < REST], axis=0) - reading
        _, Q = sampled_noise(model.A, model.intensity, STEP)
        result = extended(
            lambda i, x: self._step(x, inputs[i], slopes[i]),
            lambda i, x: (model.C @ x, model.C),
            *(y, Q, model.reading_covariance, start, start_covariance(model)),
        )
        return ExtendedEstimate(fine, self._path(result.filtered), self._path(result.smoothed))

    def _on_steps(self, fine: Array, samples: ImuSamples) -> Array:
        """(N, 6): readings at the filter's instants, NaN between them.

        The unit's instants fall between the filter's; a spline through its readings moves each to
        the nearest one, by half a step at most.
        """
        from scipy.interpolate import CubicSpline

        readings = samples.acceleration, samples.angular_velocity
        reading = np.hstack([y + np.cross(self.known.parameters.mounting, y) for y in readings])
        at = samples.time + self.known.parameters.clock_offset
        here = np.unique(np.clip(np.rint(at / STEP).astype(int), 0, len(fine) - 1))
        y = np.full((len(fine), 6), np.nan)
        y[here] = CubicSpline(at, reading)(np.clip(fine[here], at[0], at[-1]))
        return y

    def _step(self, x: Array, u: Array, slope: Array) -> tuple[Array, Array]:
        """Exact for the linearisation at x, with inputs that change linearly."""
        rate, _, local = self._motion(x, u)
        n, m, arm = len(x), 2 * local.n_free + 12, local.arm
        springs = np.hstack((np.diag(arm.stiffness), np.diag(arm.damping)))
        pulled = local.A[:, m:-6] @ (springs @ slope)  # as tau_d does, but for its own decay
        pulled[m:] = 0.0
        # dx' = A dx + rate + (B slope) t as one linear system with the states 1 and t.
        block = np.zeros((n + 2, n + 2))
        block[:n, :n], block[:n, n], block[:n, n + 1] = local.A, rate, pulled
        block[n + 1, n] = 1.0
        grown = exponential(block * STEP)
        return x + grown[:n, n], grown[:n, :n]

    def _motion(self, x: Array, u: Array) -> tuple[Array, Array, ArmFilter]:
        """x', reading of an ideal IMU (6,), and the filter's matrices at x and u = (phi, phi')."""
        model, arm = self.model, self.model.arm
        n, m, axes = model.n_free, 2 * model.n_free + 12, arm.axes
        q, q_dot, torque, pull = x[:n], x[n : 2 * n], x[m : m + n], np.empty(n)
        spring = arm.stiffness * (u[:n] - q[axes]) + arm.damping * (u[n:] - q_dot[axes])
        pull[axes] = spring + torque
        data, motion = self._data, self._motion_of
        motion.move(data, q, q_dot, np.zeros_like(q))
        mujoco.mj_inverse(motion.mj, data)
        mass, missing = motion.mass(data), pull - motion.forces(data, data.qfrc_inverse)
        q_ddot: Array = np.asarray(np.linalg.solve(mass, missing), dtype=np.float64)
        local = self._linearised(mass, q, q_dot, q_ddot)
        rate = local.A @ x
        rate[:n], rate[n : 2 * n] = q_dot, q_ddot
        # The toolbox's y: motor angles, angular velocity, specific force.
        y = self._sensor.reading(*(part[axes] for part in (q, q_dot, q_ddot)))
        reading = y[[n + 3, n + 4, n + 5, n, n + 1, n + 2]]
        for k, triad in enumerate((self.known.imu.accelerometer, self.known.imu.gyroscope)):
            low = 2 * n + 6 * k + np.arange(3)
            omega, ideal = 2.0 * np.pi * triad.bandwidth, reading[3 * k : 3 * k + 3]
            rate[low + 3] = omega**2 * (ideal - x[low]) - np.sqrt(2.0) * omega * x[low + 3]
        return rate, reading, local

    def _linearised(self, mass: Array, q: Array, q_dot: Array, q_ddot: Array) -> ArmFilter:
        """The filter's matrices with the mass and the measurement's gradient of this state."""
        model, n, axes = self.model, self.model.n_free, self.model.arm.axes
        H = self._sensor.jacobian(*(part[axes] for part in (q, q_dot, q_ddot)))
        J, gravity = np.empty((6, n)), np.empty((3, n))
        J[:3, axes], J[3:, axes] = H[n + 3 :, 2 * n :], H[n : n + 3, n : 2 * n]
        gravity[:, axes] = H[n + 3 :, :n]
        moved = replace(model.arm, mass=mass, imu_jacobian=J, imu_gravity=gravity)
        return arm_filter(moved, model.imu, self.known.parameters.process_noise)

    def _path(self, states: Array) -> Array:
        """(N, 3): the tool's displacement from rest."""
        angles = states[:, self.model.arm.axes]
        position = self._tool.pose(np.ascontiguousarray(angles))[:, :3, 3]
        return position - position[: round(0.1 / STEP)].mean(axis=0)
