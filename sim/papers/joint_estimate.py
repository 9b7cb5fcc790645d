"""Joint angles of an elastic arm from motor angles, drive torques and an accelerometer.

W. Chen, M. Tomizuka, *Direct joint space state estimation in robots with multiple elastic joints*,
IEEE/ASME Trans. Mechatronics 19(2), 697-706, 2014. All angles and torques are on the arm side.

    rough angle      q = phi - (D s + K)^-1 (tau - M_m phi'' - D_m phi' - F_m sign phi')
    acceleration     that which meets the accelerometer and is nearest to the rough one
    angle, rate      kinematic Kalman filter of each axis, from both
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from armside.arrays import Array
from armside.ilc.estimation.kinematic import KinematicFilter
from armside.ilc.filters import ZeroPhaseButterworth, butterworth, recursion

from ..estimation.linearised_arm import imu_kinematics
from ..estimation.nominal import NominalArm
from ..estimation.rigid_motion import inverse_dynamics
from ..instruments.imu import ImuCfg, TriadCfg
from ..laser.experiment import Experiment, Pass
from ..robot.drives import FRICTION_SPEED
from ..robot.model import RobotModel
from ..robot.run import measured_angle
from ..robot.servo import interpolate
from ..robot.virtual_robot import LOG_PERIOD

STEP = 1e-3
"""[s], of controller and accelerometer."""
OFFLINE, ONLINE = 30.0, 100.0
"""[Hz], low-passes of accelerometer and rough motion: zero-phase of the smoother, causal of the
filter."""
WINDOW = 500
"""Samples, of the noise of the causal filter."""
RESTS = 0.4
"""[s], of rest before the first motion, over which the accelerometer's bias is averaged: the causal
filter too takes the whole of it, so it is causal from the end of this rest on."""
KALMAN = KinematicFilter(step=STEP)
ACCELEROMETER = ImuCfg(
    rate=1.0 / STEP,
    # ADIS16400, data sheet, from memory; on the clock of the controller.
    accelerometer=TriadCfg(
        noise_density=5e-3,
        bandwidth=330.0,
        bias=0.05,
        bias_walk=2e-3,
        scale_error=1e-3,
        misalignment=np.deg2rad(0.2),
        range=176.0,
        bits=14,
    ),
    clock_offset=0.0,
)


@dataclass(frozen=True, eq=False)
class Signals:
    """What a controller has of one run, (N, n) every millisecond, arm side."""

    motor_angle: Array
    """[rad], of the encoders."""
    torque: Array
    """[N m], of the drives."""
    wanted: Array
    """[rad/s^2], of the reference."""
    acceleration: Array
    """(N, 3) [m/s^2], of the accelerometer in its axes."""


def signals(experiment: Experiment, run: Pass) -> Signals:
    """Of a run whose unit at the tool is `ACCELEROMETER`. Raises ValueError for another rate."""
    log, seen, model = run.recording, run.imu, experiment.loaded.model
    truth = log.truth.every(round(STEP / float(log.truth.time[1])))
    if seen is None or len(seen.time) != len(truth.time):
        raise ValueError(f"the accelerometer must have a sample every {1e3 * STEP:g} ms")
    _, _, wanted = interpolate(log.reference, LOG_PERIOD, round(LOG_PERIOD / STEP))
    return Signals(
        motor_angle=measured_angle(model, truth.gear_angle, None),
        torque=truth.motor_torque * model.drives.gear,
        wanted=wanted,
        acceleration=seen.acceleration,
    )


class Processing(NamedTuple):
    """Of signals (N, n), every millisecond: low-pass and rate."""

    low_pass: Callable[[Array], Array]
    rate: Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class JointEstimator:
    """The estimator on a controller's robot, and an arm of it whose gears alone give way."""

    robot: RobotModel
    arm: NominalArm

    def smoothed(self, seen: Signals) -> tuple[Array, Array]:
        """Joint angles (N, n) [rad] by all samples, and the accelerations [rad/s^2] beside them."""
        rough, nearest = self._nearest(seen, BY_ALL)
        columns = zip(rough.T, nearest.T, strict=True)
        return np.column_stack([KALMAN.smoothed(y, u)[:, 0] for y, u in columns]), nearest

    def filtered(self, seen: Signals) -> Array:
        """(N, n) [rad], by the samples up to each, from `RESTS` on."""
        columns = zip(*(each.T for each in self._nearest(seen, BY_PAST)), strict=True)
        return np.column_stack([KALMAN.filtered(y, u, WINDOW)[:, 0] for y, u in columns])

    def _nearest(self, seen: Signals, by: Processing) -> tuple[Array, Array]:
        """Rough angles (N, n) [rad], and the accelerations [rad/s^2] nearest to the rough ones that
        meet the accelerometer."""
        rough = self.rough(seen, by)
        rate = by.low_pass(by.rate(rough))
        acceleration = by.rate(rate)
        motion = self.arm.motion
        _, reading = inverse_dynamics(motion, rough, rate, acceleration)
        J, _, _ = imu_kinematics(motion, rough)
        missing = by.low_pass(seen.acceleration) - reading[:, :3]
        missing -= missing[: round(RESTS / STEP)].mean(axis=0)
        inverse = np.linalg.pinv(J[:, :3])
        return rough, acceleration + (inverse @ missing[:, :, None])[:, :, 0]

    def rough(self, seen: Signals, by: Processing) -> Array:
        """(N, n) [rad], load angles by the model of each axis."""
        arm, drives, gear = self.arm, self.robot.drives, self.robot.drives.gear
        speed = by.low_pass(by.rate(seen.motor_angle))
        friction = np.abs(gear) * drives.coulomb_friction * np.tanh(speed / FRICTION_SPEED)
        friction += gear**2 * drives.viscous_friction * speed
        inertia = self.robot.mj.dof_armature[self.robot.motor]
        carried = seen.torque - inertia * seen.wanted - friction
        # 1 / (D s + K), bilinear, from its steady state on.
        ratio = 2.0 * arm.damping / (STEP * arm.stiffness)
        twist = np.empty_like(carried)
        for j, (signal, c) in enumerate(zip((carried / arm.stiffness).T, ratio, strict=True)):
            b, a = np.array([1.0, 1.0]) / (1.0 + c), np.array([1.0, (1.0 - c) / (1.0 + c)])
            twist[:, j] = signal[0] + recursion(b, a, (signal - signal[0])[:, None])[:, 0]
        return seen.motor_angle - twist


def _causal(signal: Array) -> Array:
    """Low-pass of the past, from its steady state on."""
    found = signal - signal[0]
    for b, a in butterworth(ONLINE, STEP, 2):
        found = recursion(b, a, found)
    return signal[0] + found


def _central(signal: Array) -> Array:
    return np.gradient(signal, STEP, axis=0)


def _backward(signal: Array) -> Array:
    return np.diff(signal, axis=0, prepend=signal[:1]) / STEP


BY_ALL = Processing(ZeroPhaseButterworth(OFFLINE, STEP), _central)
BY_PAST = Processing(_causal, _backward)
"""Of the smoother, and of the causal filter."""


def tool_positions(arm: NominalArm, angle: Array) -> Array:
    """(N, 3) [m], base axes, of the tool at joint angles (N, n) [rad]."""
    motion, data = arm.motion, arm.motion.data()
    site, found = motion.mj.site("tool0").id, np.empty((len(angle), 3))
    for i, q in enumerate(angle):
        motion.place(data, q)
        mujoco.mj_kinematics(motion.mj, data)
        found[i] = data.site_xpos[site]
    return found
