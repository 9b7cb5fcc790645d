"""The virtual robot: a flexible arm with its servo, run as one rollout of the physics.

A run is open loop for the program: reference r and correction u are known before it, so the whole
run, servo included, is one call of `mujoco.rollout` with no Python in the step loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from .individual import braked_at
from .instruments.encoder import quantise
from .instruments.noise import band_limited, white
from .model import N_AXES, RobotModel
from .recording import Array, Recording, Truth
from .servo import (
    at_step_end,
    correction_path,
    encoder_perturbation,
    friction_torque,
    interpolate,
    motor_controls,
    substeps,
)
from .statics import Statics

LOG_PERIOD = 0.004
"""[s], of the motor log, r and u. Thesis 5.1.2; numbers.md section 4 confirms it for chapter 9."""

_FULL_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


class VirtualRobot:
    """One robot individual. `load` a reference, then `run` it as often as needed."""

    def __init__(
        self,
        model: RobotModel,
        *,
        nominal: RobotModel | None = None,
        log_period: float = LOG_PERIOD,
    ) -> None:
        """Args:
        nominal: what its controller computes torques with; the robot itself if None.
        log_period: [s], a whole number of physics steps.
        """
        self.model = model
        self.nominal = nominal or model
        self.log_period = log_period
        self._ratio = substeps(model.timestep, log_period)

    def load(self, reference: Array, *, motors_on_at: float = 0.0) -> "Job":
        """Prepare the servo's inputs for a reference, starting at rest in static equilibrium.

        Args:
            reference: (N, 6) [rad], r at the log rate, arm-side motor angles; at rest at both ends.
            motors_on_at: [s]; before it the brakes hold the arm and the drives carry no current.

        Raises ValueError for a wrong shape, values that are not finite, or brakes the robot lacks.
        """
        reference = _checked(reference, "reference")
        model, drives = self.model, self.model.drives
        statics = Statics(model)
        position, velocity, _ = interpolate(reference, self.log_period, self._ratio)
        torque = self._feedforward(reference, velocity)
        if model.gear_error is not None:
            # The servo brings the measured angle q - epsilon(q) to the reference.
            error_rate = model.gear_error.rate(position, velocity)
            position = position + model.gear_error(position)
        start = statics.equilibrium(position[0])
        torque += start.holding_torque - torque[0]
        powered = np.arange(len(position)) * model.timestep >= motors_on_at
        if not powered.all():
            model = braked_at(model, position[0])
            torque[~powered] = 0.0
        velocity = drives.velocity_feedforward * velocity
        if model.gear_error is not None:
            velocity += error_rate
        if model.implicit:
            velocity = at_step_end(velocity)
        return Job(
            model=model,
            log_period=self.log_period,
            ratio=self._ratio,
            reference=reference,
            controls=motor_controls(model, position, velocity, torque),
            powered=powered,
            initial_state=_initial_state(model.mj, start.qpos),
        )

    def run(
        self,
        reference: Array,
        correction: Array | None = None,
        rng: np.random.Generator | None = None,
    ) -> Recording:
        """Load a reference and run it once. See `Job.run`."""
        return self.load(reference).run(correction, rng)

    def _feedforward(self, reference: Array, velocity: Array) -> Array:
        """(M, 6) [N m], arm side: rigid computed torque, evaluated at the log rate and splined."""
        statics, drives = Statics(self.nominal), self.nominal.drives
        if drives.torque_feedforward == 0.0:
            return np.zeros_like(velocity)
        _, phi_dot, phi_ddot = interpolate(reference, self.log_period, 1)
        forces = statics.rigid_forces(reference, phi_dot, phi_ddot)
        torque, _, _ = interpolate(statics.motor_torque(forces), self.log_period, self._ratio)
        if drives.friction_feedforward > 0.0:
            torque += friction_torque(drives, velocity)
        return drives.torque_feedforward * torque


@dataclass(frozen=True, kw_only=True)
class Job:
    """A reference loaded into a robot: everything of a run that the correction does not change."""

    model: RobotModel
    log_period: float
    ratio: int
    reference: Array
    """(N, 6) [rad]."""
    controls: Array
    """(M, 18), motor units, with zero correction and no noise."""
    powered: np.ndarray
    """(M,) bool: the drives are on; otherwise the brakes hold."""
    initial_state: Array
    """Full physics state: static equilibrium at the first reference."""

    def run(
        self, correction: Array | None = None, rng: np.random.Generator | None = None
    ) -> Recording:
        """Run once.

        Args:
            correction: (N, 6) [rad], u; zero if None.
            rng: source of the non-repeatable torque; without it the run is noise-free.
        """
        return run_jobs([self], [correction], [rng])[0]

    def controls_with(
        self, correction: Array, rng: np.random.Generator | None
    ) -> tuple[Array, Array | None]:
        """The controls (M, 18) of one run, correction and noise added, and the encoder noise.

        Encoder noise (M, 6) [motor rad] is None where there is none. It perturbs the set points:
        pos - (q + n) = (pos - n) - q, so the servo stays inside the physics.
        """
        drives, step = self.model.drives, self.model.timestep
        path = correction_path(
            correction,
            self.log_period,
            self.ratio,
            drives.correction_delay,
            drives.correction_lag,
        )
        controls = self.controls.copy().reshape(-1, N_AXES, 3)
        on = self.powered[:, None]
        controls[:, :, 0] += drives.gear * path.position
        velocity = at_step_end(path.velocity) if self.model.implicit else path.velocity
        controls[:, :, 1] += drives.gear * drives.velocity_feedforward * velocity
        encoder_noise = None
        if rng is not None and drives.torque_noise > 0.0:
            controls[:, :, 2] += on * band_limited(
                rng,
                (len(controls), N_AXES),
                drives.torque_noise * drives.torque_limit,
                drives.torque_noise_bandwidth,
                step,
            )
        if rng is not None and drives.encoder_noise > 0.0 and drives.encoder_counts > 0.0:
            std = drives.encoder_noise * 2.0 * np.pi / drives.encoder_counts
            encoder_noise = white(rng, (len(controls), N_AXES), std)
            controls[:, :, 0] -= on * encoder_noise
            controls[:, :, 1] -= on * encoder_perturbation(encoder_noise, step)
        return controls.reshape(len(controls), -1), encoder_noise


def run_jobs(
    jobs: Sequence[Job],
    corrections: Sequence[Array | None],
    rngs: Sequence[np.random.Generator | None],
    *,
    threads: int = 1,
) -> list[Recording]:
    """Run several jobs of equal length, each on its own model, in one call of the physics.

    The result does not depend on the number of threads.
    """
    wanted = [
        np.zeros_like(job.reference) if u is None else _checked(u, "correction", job.reference)
        for job, u in zip(jobs, corrections, strict=True)
    ]
    inputs = [job.controls_with(u, rng) for job, u, rng in zip(jobs, wanted, rngs, strict=True)]
    controls = np.stack([of_job for of_job, _ in inputs])
    states, sensors = _roll_out(jobs, controls, threads)
    return [
        _recording(job, wanted[i], controls[i], inputs[i][1], states[i], sensors[i])
        for i, job in enumerate(jobs)
    ]


def _roll_out(jobs: Sequence[Job], controls: Array, threads: int) -> tuple[Array, Array]:
    models = [job.model.mj for job in jobs]
    initial = np.stack([job.initial_state for job in jobs])
    n_data = min(threads, len(jobs))
    data = [mujoco.MjData(models[0]) for _ in range(n_data)]
    what = mujoco.mjtState.mjSTATE_CTRL
    if not all(job.powered.all() for job in jobs):
        what |= mujoco.mjtState.mjSTATE_EQ_ACTIVE
        closed = np.stack([_closed_constraints(job) for job in jobs])
        controls = np.concatenate((controls, closed), axis=2)
    with Rollout(nthread=n_data if n_data > 1 else 0) as rollout:
        result = rollout.rollout(models, data, initial, controls, control_spec=int(what))
    states, sensors = (np.asarray(part, dtype=np.float64) for part in result)
    for i, job in enumerate(jobs):
        _blank_after_instability(states[i], sensors[i], job.model.timestep)
    return states, sensors


def _closed_constraints(job: Job) -> Array:
    """(M, neq): those of the model throughout, and its brakes while the drives are off."""
    mj = job.model.mj
    closed = np.tile(mj.eq_active0.astype(np.float64), (len(job.powered), 1))
    closed[:, job.model.brakes] = ~job.powered[:, None]
    return closed


def _blank_after_instability(states: Array, sensors: Array, step: float) -> None:
    """Where the physics gave up, the rollout repeats its last state: time stands still there."""
    if states[-1, 0] < (len(states) - 0.5) * step:
        unstable = int(np.argmax(np.diff(states[:, 0]) < 0.5 * step)) + 1
        states[unstable:] = np.nan
        sensors[unstable:] = np.nan


def _recording(
    job: Job,
    correction: Array,
    controls: Array,
    encoder_noise: Array | None,
    states: Array,
    sensors: Array,
) -> Recording:
    """Arrange one run. Sensor row i belongs to time i h, state row i to (i + 1) h."""
    model, step = job.model, job.model.timestep
    nq, motor = model.mj.nq, model.motor
    qpos = _before_step(job.initial_state, states, 1 + np.arange(nq))
    velocity = _before_step(job.initial_state, states, 1 + nq + motor)
    time: Array = np.arange(len(states), dtype=np.float64) * step
    integral = _before_step(job.initial_state, states, 1 + nq + model.mj.nv + model.integrator)
    torque = drive_torque(model, controls, qpos[:, motor], velocity, integral)
    angle = qpos[:, motor]
    flex = qpos[:, model.flex] if len(model.flex) else np.zeros((len(time), N_AXES))
    if model.gear_error is not None:
        error = model.gear_error(angle)
        angle, flex = angle - error, flex + error
    truth = Truth(
        time=time,
        motor_angle=angle,
        flex_angle=flex,
        motor_torque=torque,
        tool_position=sensors[:, model.sensors["tool0_pos"]],
        tool_quaternion=sensors[:, model.sensors["tool0_quat"]],
        imu_acceleration=sensors[:, model.sensors["imu_acc"]],
        imu_angular_velocity=sensors[:, model.sensors["imu_gyro"]],
        qpos=qpos,
    )
    log = slice(None, None, job.ratio)
    angle = truth.motor_angle[log]
    if encoder_noise is not None:
        angle = angle + encoder_noise[log] / model.drives.gear
    if model.drives.encoder_counts > 0.0:
        angle = quantise(angle, model.drives.encoder_counts, model.drives.gear)
    return Recording(
        time=time[log],
        reference=job.reference,
        correction=correction,
        motor_angle=angle,
        motor_torque=torque[log],
        truth=truth,
        limits_hit=limits_hit(model, truth, velocity),
    )


def _before_step(initial: Array, states: Array, columns: np.ndarray) -> Array:
    """Columns of the state at the start of each step: the initial state, then all but the last."""
    values = np.empty((len(states), len(columns)))
    values[0] = initial[columns]
    values[1:] = states[:-1, columns]
    return values


def drive_torque(
    model: RobotModel, controls: Array, angle: Array, velocity: Array, integral: Array
) -> Array:
    """(M, 6) [motor N m] that the drives deliver: the servo's law, limited.

    Args:
        controls: (M, 18), motor units.
        angle, velocity: (M, 6) [rad], [rad/s], arm side, at the same instants.
        integral: (M, 6) [rad s], motor side, of the position error; (M, 0) without integral gain.
    """
    drives = model.drives
    position, speed, torque = np.moveaxis(controls.reshape(-1, N_AXES, 3), 2, 0)
    asked = (
        drives.kp * (position - drives.gear * angle)
        + drives.kd * (speed - drives.gear * velocity)
        + torque
    )
    if integral.shape[1]:
        asked += drives.ki * integral
    return np.clip(asked, -drives.torque_limit, drives.torque_limit)


def limits_hit(
    model: RobotModel, truth: Truth, velocity: Array
) -> tuple[tuple[str, int, float], ...]:
    """Each limit that a run touched, as (limit, axis 1..6, first time [s])."""
    drives, reach = model.drives, model.joint_range
    angle, torque = truth.motor_angle, truth.motor_torque
    watched = (
        ("torque", torque, -drives.torque_limit, drives.torque_limit),
        ("speed", velocity, -drives.speed_limit, drives.speed_limit),
        ("joint", angle, reach[:, 0], reach[:, 1]),
    )
    hits: list[tuple[str, int, float]] = []
    for name, signal, low, high in watched:
        touched = (signal.min(axis=0) <= low) | (signal.max(axis=0) >= high)
        for axis in np.flatnonzero(touched):
            beyond = (signal[:, axis] <= low[axis]) | (signal[:, axis] >= high[axis])
            hits.append((name, int(axis) + 1, float(truth.time[np.argmax(beyond)])))
    return tuple(hits)


def _initial_state(mj: mujoco.MjModel, qpos: Array) -> Array:
    data = mujoco.MjData(mj)
    data.qpos[:] = qpos
    state = np.empty(mujoco.mj_stateSize(mj, int(_FULL_STATE)))
    mujoco.mj_getState(mj, data, state, int(_FULL_STATE))
    return state


def _checked(values: Array, name: str, like: Array | None = None) -> Array:
    values = np.array(values, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != N_AXES or len(values) < 2:
        raise ValueError(f"{name} must have shape (N, {N_AXES}), got {values.shape}")
    if like is not None and values.shape != like.shape:
        raise ValueError(f"{name} has {len(values)} samples, the reference has {len(like)}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds values that are not finite")
    values.setflags(write=False)
    return values
