"""Runs of a loaded reference: controls, one rollout of the physics, and the record of the run.

A run adds a correction and noise to the controls of the servo, and rolls the physics out. Its
record follows from states and sensors; the torque of the servo is computed again from the states.
"""

import logging
import os
import threading
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from armside.arrays import Array

from ..instruments.encoder import quantise
from ..instruments.noise import band_limited, white
from .drives import EXACT
from .model import RobotModel
from .recording import Recording, Truth
from .servo import at_step_end, correction_path, encoder_perturbation

_log = logging.getLogger(__name__)

if mujoco.get_mju_user_warning() is None:
    # MuJoCo itself would write a file into the current folder. An unstable run is recognised by its
    # samples, which are not finite.
    mujoco.set_mju_user_warning(_log.info)


@dataclass(frozen=True, kw_only=True)
class LoadedReference:
    """A reference loaded into a robot: all inputs of a run but correction and noise."""

    model: RobotModel
    log_period: float
    ratio: int
    reference: Array
    """(N, n) [rad]."""
    controls: Array
    """(M, 3 n), motor units, with zero correction and no noise."""
    powered: np.ndarray
    """(M,) bool: the drives are on; otherwise the brakes hold."""
    initial_state: Array
    """Full physics state: static equilibrium at the first reference."""
    applied: Array | None = None
    """(M, n) [N m], arm side, on the motors by `RobotModel.own_drive`."""

    def run(
        self, correction: Array | None = None, rng: np.random.Generator | None = None
    ) -> Recording:
        """Run once with a correction (N, n) [rad], zero if None; noise-free without `rng`."""
        return run_batch([self], [correction], [rng])[0]

    def controls_with(
        self, correction: Array, rng: np.random.Generator | None
    ) -> tuple[Array, Array | None]:
        """The controls (M, 3 n) of one run, correction and noise added, and the encoder noise.

        Encoder noise (M, n) [motor rad] is None where there is none. It perturbs the set points:
        pos - (q + n) = (pos - n) - q, so the servo stays inside the physics.
        """
        drives = self.model.drives
        delay, lag = drives.correction_delay, drives.correction_lag
        path = correction_path(correction, self.log_period, self.ratio, delay, lag)
        controls = self.controls.copy().reshape(len(self.controls), -1, 3)
        velocity = at_step_end(path.velocity) if self.model.implicit else path.velocity
        noise = self.noise(rng)
        self.add(controls, slice(None), path.position, velocity, noise)
        if self.model.own_drive is not None:
            controls = self.model.own_drive.commands(controls, self.model.timestep)
        return controls.reshape(len(controls), -1), noise.encoder

    def noise(self, rng: np.random.Generator | None) -> "Noise":
        """Draw the noise of one run; none without `rng`."""
        drives, step = self.model.drives, self.model.timestep
        torque = encoder = perturbation = None
        shape = len(self.controls), self.model.n_axes
        if rng is not None and drives.torque_noise > 0.0:
            std = drives.torque_noise * drives.torque_limit
            torque = band_limited(rng, shape, std, drives.torque_noise_bandwidth, step)
        if rng is not None and drives.encoder_noise > 0.0 and drives.encoder_counts > 0.0:
            std = drives.encoder_noise * 2.0 * np.pi / drives.encoder_counts
            encoder = white(rng, shape, std)
            perturbation = encoder_perturbation(encoder, step)
        return Noise(torque, encoder, perturbation)

    def add(
        self, controls: Array, rows: slice, position: Array, velocity: Array, noise: "Noise"
    ) -> None:
        """Add a correction's path and noise to `controls` (m, n, 3), those of `rows`.

        position, velocity: (m, n) [rad] and [rad/s], of the correction after its lag, arm side.
        """
        drives, on = self.model.drives, self.powered[rows, None]
        controls[:, :, 0] += drives.gear * position
        controls[:, :, 1] += drives.gear * drives.velocity_feedforward * velocity
        if noise.torque is not None:
            controls[:, :, 2] += on * noise.torque[rows]
        if noise.encoder is not None and noise.perturbation is not None:
            controls[:, :, 0] -= on * noise.encoder[rows]
            controls[:, :, 1] -= on * noise.perturbation[rows]


@dataclass(frozen=True)
class Noise:
    """Noise of one run at the physics rate, each (M, n) or None where there is none."""

    torque: Array | None
    """[N m], motor side."""
    encoder: Array | None
    perturbation: Array | None
    """[motor rad], and what it makes of the measured speed [motor rad/s]."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_batch(
    references: Sequence[LoadedReference],
    corrections: Sequence[Array | None],
    rngs: Sequence[np.random.Generator | None],
    *,
    threads: int = 1,
) -> list[Recording]:
    """Run several loaded references of equal length in one rollout, whatever the threads."""
    applied = [
        np.zeros_like(x.reference)
        if u is None
        else checked_signal(u, "correction", x.model.n_axes, x.reference)
        for x, u in zip(references, corrections, strict=True)
    ]
    inputs = [x.controls_with(u, rng) for x, u, rng in zip(references, applied, rngs, strict=True)]
    each, noises = [controls for controls, _ in inputs], [noise for _, noise in inputs]
    controls = each[0][None] if len(each) == 1 else np.stack(each)
    parts = references, applied, controls, noises, *_roll_out(references, controls, threads)
    return [recorded(*part) for part in zip(*parts, strict=True)]


def recorded(
    loaded: LoadedReference,
    u: Array,
    controls: Array,
    encoder_noise: Array | None,
    states: Array,
    sensors: Array,
) -> Recording:
    """Record of a run, or of its first N samples: u is (N, n), the others have rows for them."""
    happened, limits = truth(loaded.model, loaded.initial_state, controls, states, sensors)
    log = slice(None, None, loaded.ratio)
    noise = None if encoder_noise is None else encoder_noise[log]
    return Recording(
        time=happened.time[log],
        reference=loaded.reference[: len(u)],
        correction=u,
        motor_angle=measured_angle(loaded.model, happened.gear_angle[log], noise),
        motor_torque=happened.motor_torque[log],
        truth=happened,
        limits_hit=limits,
    )


def _roll_out(
    references: Sequence[LoadedReference], controls: Array, threads: int
) -> tuple[Array, Array]:
    models = [loaded.model.mj for loaded in references]
    initial = np.stack([loaded.initial_state for loaded in references])
    n_data = min(threads, len(references))
    data = _data(models[0], n_data)
    inputs = mujoco.mjtState.mjSTATE_CTRL
    if any(loaded.applied is not None for loaded in references):
        inputs |= mujoco.mjtState.mjSTATE_QFRC_APPLIED
        forces = np.zeros((*controls.shape[:2], models[0].nv))
        for i, loaded in enumerate(references):
            if loaded.applied is not None:
                forces[i, :, loaded.model.motor] = loaded.applied.T
        controls = np.concatenate((controls, forces), axis=2)
    if not all(loaded.powered.all() for loaded in references):
        inputs |= mujoco.mjtState.mjSTATE_EQ_ACTIVE
        # Constraints of the model throughout, and its brakes while the drives are off.
        closed = np.stack(
            [
                np.tile(x.model.mj.eq_active0.astype(np.float64), (len(x.powered), 1))
                for x in references
            ]
        )
        for active, loaded in zip(closed, references, strict=True):
            active[:, loaded.model.brakes] = ~loaded.powered[:, None]
        controls = np.concatenate((controls, closed), axis=2)
    alone = _ROLLOUT_ON_THREADS if n_data > 1 else nullcontext()
    with alone, Rollout(nthread=n_data if n_data > 1 else 0) as rollout:
        result = rollout.rollout(models, data, initial, controls, control_spec=int(inputs))
    states, sensors = (np.asarray(part, dtype=np.float64) for part in result)
    for i, loaded in enumerate(references):
        time, step = states[i, :, 0], loaded.model.timestep
        if time[-1] < (len(time) - 0.5) * step:  # from there on the last state and time repeat
            unstable = int(np.argmax(np.diff(time) < 0.5 * step)) + 1
            states[i, unstable:] = sensors[i, unstable:] = np.nan
    return states, sensors


_ROLLOUT_ON_THREADS = threading.Lock()
"""Held by a rollout on several threads. Two beside each other would end together, and cores wait
while Python loads the next of both; one after the other, it loads beside the physics."""
_kept = threading.local()


def _data(mj: mujoco.MjModel, count: int) -> list[mujoco.MjData]:
    """Reset simulation data, those of the thread's last run if they fit: a new one takes 0.4 ms."""
    kept: list[mujoco.MjData] = getattr(_kept, "data", [])
    if not kept or kept[0].signature != mj.signature:
        kept = []
    kept = kept + [mujoco.MjData(mj) for _ in range(count - len(kept))]
    _kept.data = kept
    for data in kept[:count]:
        mujoco.mj_resetData(mj, data)
    return kept[:count]


def checked_signal(values: Array, name: str, n_axes: int, like: Array | None = None) -> Array:
    """A read-only copy, (N, n). Raises ValueError for a wrong shape or values not finite."""
    values = np.array(values, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != n_axes or len(values) < 2:
        raise ValueError(f"{name} must have shape (N, {n_axes}), got {values.shape}")
    if like is not None and values.shape != like.shape:
        raise ValueError(f"{name} has {len(values)} samples, the reference has {len(like)}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds values that are not finite")
    values.setflags(write=False)
    return values


Limits = tuple[tuple[str, int, float], ...]
"""Each limit that a run touched, as (limit, axis 1..n, first time [s])."""

WATCHED = ("torque", "speed", "joint")
"""Limits that a run is checked against."""


def truth(
    model: RobotModel, initial_state: Array, controls: Array, states: Array, sensors: Array
) -> tuple[Truth, Limits]:
    """Ground truth of one run. Sensor row i belongs to time i h, state row i to (i + 1) h.

    controls: (M, nu) in motor units; states, sensors: (M, ...), as the rollout returns them.
    """
    time: Array = np.arange(len(states), dtype=np.float64) * model.timestep
    drives, nq, nv = model.drives, model.mj.nq, model.mj.nv
    rows = np.vstack((initial_state, states[:-1]))
    qpos, qvel = rows[:, 1 : 1 + nq], rows[:, 1 + nq : 1 + nq + nv]
    angle, speed = qpos[:, model.motor], qvel[:, model.motor]
    # The torque of the servo law, limited, with the speed at the start of a step.
    position, velocity, added = np.moveaxis(controls.reshape(len(states), -1, 3), 2, 0)
    wanted = drives.kp * (position - drives.gear * angle)
    wanted = wanted + drives.kd * (velocity - drives.gear * speed) + added
    if len(model.integrator):
        wanted += drives.ki * rows[:, 1 + nq + nv + model.integrator]
    torque = np.clip(wanted, -drives.torque_limit, drives.torque_limit)
    spring = qpos[:, model.flex] if len(model.flex) else np.zeros_like(angle)
    record = Truth(
        time=time,
        gear_angle=angle,
        spring_angle=spring,
        motor_torque=torque,
        tool_position=sensors[:, model.sensors["tool0_pos"]],
        tool_quaternion=sensors[:, model.sensors["tool0_quat"]],
        imu_acceleration=sensors[:, model.sensors["imu_acc"]],
        imu_angular_velocity=sensors[:, model.sensors["imu_gyro"]],
        qpos=qpos,
        gear_error=model.gear_error or EXACT,
    )
    low, high = model.joint_range.T
    watched = (
        (torque, -drives.torque_limit, drives.torque_limit),
        (speed, -drives.speed_limit, drives.speed_limit),
        (angle, low, high),
    )
    reached = [(value <= low) | (value >= high) for value, low, high in watched]
    hits = [
        (name, int(axis) + 1, float(time[np.argmax(over[:, axis])]))
        for name, over in zip(WATCHED, reached, strict=True)
        for axis in np.flatnonzero(over.any(axis=0))
    ]
    return record, tuple(hits)


def measured_angle(model: RobotModel, gear_angle: Array, encoder_noise: Array | None) -> Array:
    """Encoder readings (N, n) [rad], arm side, at gear angles; encoder noise in [motor rad]."""
    drives, motor_angle = model.drives, gear_angle
    if model.gear_error is not None:
        motor_angle = motor_angle - model.gear_error(gear_angle)
    if encoder_noise is not None:
        motor_angle = motor_angle + encoder_noise / drives.gear
    if drives.encoder_counts > 0.0:
        motor_angle = quantise(motor_angle, drives.encoder_counts, drives.gear)
    return motor_angle
