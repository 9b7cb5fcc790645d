"""Learning inside a twin: the correction that its tool needs for a contour.

A linear law takes friction for a disturbance that repeats. Where a motor reverses it does not: the
motion that the law asks for has its friction elsewhere, and learning creeps. Inside a twin friction
is known: LuGre, as in the physics,

    z' = v - s0 |v| z / g(v)        g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2)        F = s0 z + s1 z'

The law's step is completed by the correction whose torque is F(new motion) - F(old motion).
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from numba import njit

from armside.arrays import Array
from armside.ilc.laws.model_based import RegularisedInverse, tapered
from armside.ilc.models.system import Complex

from ..estimation.arm_plant import ArmPlant
from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalCfg, nominal_arm
from ..estimation.relative_path import relative_to_start
from ..laser.experiment import Experiment, of_motion
from ..robot.individual import Individual, joints
from ..robot.mjcf import AXES, N_AXES, axis_actuators
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.virtual_robot import LOG_PERIOD
from .simulation import RobotDesign

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


@dataclass(frozen=True, kw_only=True)
class TwinLearning:
    """Options of learning inside a twin, which has no noise."""

    updates: int = 7
    gamma: float = 0.9
    cutoff: float = 30.0
    """[Hz], of Q: above it no law is needed, and no twin is right."""
    regularisation: float = 0.001
    """Of the inverse, relative: see `RegularisedInverse`."""
    limit: float = 0.02
    """Largest displacement of the tool by the correction of each axis [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Learned:
    """Correction learned inside a twin."""

    correction: Array
    """(N, 6) [rad], arm side."""
    rms: Array
    """(updates + 1,) [m], tool error inside the twin, from that without correction on. Shorter
    where a run became unstable."""

    @property
    def left(self) -> float:
        """Tool error inside the twin with the correction, over that without."""
        return float(self.rms.min() / self.rms[0])


def learn_in_twin(
    design: RobotDesign,
    individual: Individual,
    experiment: Experiment,
    cfg: TwinLearning = TwinLearning(),
) -> Learned:
    """The best correction of a few updates inside the twin."""
    reference = experiment.loaded.reference
    loaded = design.load(individual, reference)
    target = relative_to_start(experiment.programmed)
    place = reference[experiment.cut.centre(experiment.motion)]
    u, best = np.zeros_like(reference), np.zeros_like(reference)
    rms: list[float] = []
    for k in range(cfg.updates + 1):
        run = loaded.run(u)
        rms.append(twin_error(experiment, run))
        if not np.isfinite(rms[-1]):
            break
        if rms[-1] <= min(rms):
            best = u
        if k < cfg.updates:
            plant = twin_plant(design, loaded, run, place)
            step = FrictionStep(law=_law(plant, cfg), plant=plant, robot=loaded.model)
            u = step(u, target - tool_pose_path(run), run)
    return Learned(correction=best, rms=np.array(rms))


def twin_error(
    experiment: Experiment, run: Recording, clock: tuple[Array, Array] | None = None
) -> float:
    """RMS tool error [m] of a run of a twin, over all contours, as a tracker of 1 kHz would see it.

    Infinite where the run became unstable. clock: as of `Pass`.
    """
    truth, cut, motion = run.truth, experiment.cut, experiment.motion
    if not np.isfinite(truth.tool_position).all():
        return float("inf")
    every = slice(None, None, round(1e-3 / float(truth.time[1])))
    seen = of_motion(truth.time[every], clock), truth.tool_position[every]
    return cut.whole(motion, cut.errors(motion, *seen, edges=False)).rms


_WEIGHT = (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
"""Of displacements, and of rotations [m]: 1 mrad counts as 0.1 mm."""


def _law(plant: ArmPlant, cfg: TwinLearning) -> RegularisedInverse:
    return RegularisedInverse(
        G=plant,
        sample_time=LOG_PERIOD,
        cutoff=cfg.cutoff,
        gamma=cfg.gamma,
        output_weight=_WEIGHT,
        input_size=tuple(float(s) for s in plant.input_size),
        regularisation=cfg.regularisation,
        limit=cfg.limit,
    )


def twin_plant(
    design: RobotDesign, loaded: LoadedReference, run: Recording, phi: Array | None = None
) -> ArmPlant:
    """Response of the tool to corrections, linearised along a run of the twin.

    phi: (6,) [rad], pose of the linearisation; the first of the run if None.

    Each gear has its mean slope along that run: one without load stays within its lost motion, and
    is soft.
    """
    own = 0.0 if design.payload is None else design.payload - design.model.mj.body("tool").mass[0]
    cfg = NominalCfg(structure=True, payload=float(own))
    arm = nominal_arm(design.model, cfg)
    _copy_hinges(loaded.model.mj, arm.mj)
    arm = arm.with_springs(mean_gear_stiffness(loaded.model, run), arm.damping)
    still = linearised(arm, loaded.reference[0] if phi is None else phi)
    return ArmPlant(robot=design.nominal or design.model, arm=still, period=LOG_PERIOD)


def _copy_hinges(twin: mujoco.MjModel, arm: mujoco.MjModel) -> None:
    """Give the hinges of the structure in an arm the numbers that a twin has."""
    for joint in (*joints(twin, "struct_"), *joints(twin, "hidden_")):
        own = arm.joint(twin.joint(joint).name).id
        arm.jnt_axis[own], arm.jnt_pos[own] = twin.jnt_axis[joint], twin.jnt_pos[joint]
        arm.jnt_stiffness[own] = twin.jnt_stiffness[joint]


def mean_gear_stiffness(model: RobotModel, run: Recording) -> Array:
    """(6,) [N m/rad], mean slope of each gear spring along a run."""
    mj, stiffness = model.mj, np.empty(N_AXES)
    for i in AXES:
        wound = run.truth.spring_angle[:, i - 1]
        tendon = mj.tendon(f"gear_{i}").id
        low, high = mj.tendon_lengthspring[tendon]
        outside = float(np.mean((wound < low) | (wound > high)))
        soft = mj.jnt_stiffness[mj.joint(f"flex_{i}").id]
        stiffness[i - 1] = soft + outside * mj.tendon_stiffness[tendon]
    return stiffness


def tool_pose_path(run: Recording) -> Array:
    """(N, 6), displacement [m] and rotation [rad] of the tool from rest, at the log's instants."""
    every = round(float(run.time[1] / run.truth.time[1]))
    return relative_to_start(run.truth.tool_position[::every], run.truth.tool_quaternion[::every])
