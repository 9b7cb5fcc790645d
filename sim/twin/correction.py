"""Learning inside a twin: the correction that its tool needs for a contour.

A linear law takes friction for a disturbance that repeats. Where a motor reverses it does not: the
motion that the law asks for has its friction elsewhere, and learning creeps. Inside a twin friction
is known: LuGre, as in the physics,

    z' = v - s0 |v| z / g(v)        g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2)        F = s0 z + s1 z'

The law's step is completed by the correction whose torque is F(new motion) - F(old motion).
"""

from collections.abc import Iterable

import numpy as np
from numba import njit

from armside.arrays import Array
from armside.ilc.laws.model_based import RegularisedInverse, ScheduledInverse, tapered
from armside.ilc.models.system import Complex

from ..estimation.arm_plant import ArmPlant, PathPlants, fading, places_along
from ..estimation.linearised_arm import linearised
from ..estimation.nominal import NominalCfg, nominal_arm
from ..estimation.relative_path import relative_to_start
from ..laser.experiment import Experiment, of_motion
from ..robot.individual import Individual, joints
from ..robot.mjcf import AXES, axis_actuators
from ..robot.model import RobotModel
from ..robot.recording import Recording
from ..robot.run import LoadedReference
from ..robot.virtual_robot import LOG_PERIOD
from .simulation import RobotDesign

_COULOMB, _STATIC, _STRIBECK = 3, 4, 5
_BRISTLE, _BRISTLE_DAMPING = 5, 6


def friction_step(
    law: ScheduledInverse,
    plants: PathPlants,
    robot: RobotModel,
    correction: Array,
    error: Array,
    run: Recording,
) -> Array:
    """Next correction (N, 6) [rad], after a run of the twin `robot` with the tool's error (N, 6): a
    linear law's, completed by the friction of what it asks for."""
    learned = law(correction, error)
    omega = 2.0 * np.pi * np.fft.rfftfreq(2 * len(correction))
    moved = _along(plants, (p.motor_response(omega) for p in plants.plants), learned - correction)
    truth, gear = run.truth, robot.drives.gear
    step = float(truth.time[1])
    fine = np.column_stack([np.interp(truth.time, run.time, column) for column in moved.T])
    old = np.gradient(truth.gear_angle, step, axis=0) * gear
    new = old + np.gradient(fine, step, axis=0) * gear
    constants = friction_constants(robot)
    change = gear * (lugre(new, step, constants) - lugre(old, step, constants))
    every = round(float(run.time[1]) / step)
    box = np.ones(every) / every
    extra = [np.convolve(column, box, mode="same")[::every] for column in change.T]
    Q = law.laws[0].Q(omega)[:, None, None]
    paid = (Q * plant.torque_response(omega) for plant in plants.plants)
    return learned + _along(plants, paid, np.column_stack(extra))


def friction_constants(robot: RobotModel) -> Array:
    """(5, 6): s0, s1, Fc, Fs [motor N m] and vs [motor rad/s] of each drive."""
    mj, axes = robot.mj, axis_actuators(robot.mj)
    dynamics, bias = mj.actuator_dynprm[axes].T, mj.actuator_biasprm[axes].T
    friction = bias[_COULOMB], bias[_STATIC], bias[_STRIBECK]
    return np.stack((dynamics[_BRISTLE], dynamics[_BRISTLE_DAMPING], *friction))


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


def _along(plants: PathPlants, responses: Iterable[Complex], signal: Array) -> Array:
    """(N, m), of responses at the places of the plants, which fade from one to the next."""
    n, found = len(signal), np.zeros_like(signal)
    spectrum = np.fft.rfft(tapered(signal), axis=0)[:, :, None]
    for weight, response in zip(plants.weights.T, responses, strict=True):
        moved = np.fft.irfft((response @ spectrum)[:, :, 0], 2 * n, axis=0)[:n]
        found += weight[:, None] * moved
    return found


UPDATES = 7
GAMMA = 0.9
CUTOFF = 30.0
"""[Hz], of Q: above it no law is needed, and no twin is right."""
REGULARISATION = 0.001
"""Of the inverse, relative: see `RegularisedInverse`."""
LIMIT = 0.02
"""Largest displacement of the tool by the correction of each axis [m]."""
WEIGHT = (1.0, 1.0, 1.0, 0.1, 0.1, 0.1)
"""Of displacements, and of rotations [m]: 1 mrad counts as 0.1 mm."""


def learn_in_twin(
    design: RobotDesign, individual: Individual, experiment: Experiment
) -> tuple[Array, Array]:
    """The best correction (N, 6) [rad] of a few updates inside the twin, and its tool errors (k,)
    [m] from that without correction on: fewer where a run became unstable."""
    reference = experiment.loaded.reference
    loaded = design.load(individual, reference)
    target = relative_to_start(experiment.programmed)
    _, samples = places_along(reference)
    time: Array = np.arange(len(reference), dtype=np.float64)
    weights = fading(time[samples], time)
    u, best = np.zeros_like(reference), np.zeros_like(reference)
    rms: list[float] = []
    for k in range(UPDATES + 1):
        run = loaded.run(u)
        rms.append(twin_error(experiment, run))
        if not np.isfinite(rms[-1]):
            break
        if rms[-1] <= min(rms):
            best = u
        if k < UPDATES:
            plants = _twin_plants(design, loaded, run, reference[samples], weights)
            laws = [
                RegularisedInverse(
                    G=plant,
                    sample_time=LOG_PERIOD,
                    cutoff=CUTOFF,
                    gamma=GAMMA,
                    output_weight=WEIGHT,
                    input_size=tuple(float(s) for s in plant.input_size),
                    regularisation=REGULARISATION,
                    limit=LIMIT,
                )
                for plant in plants.plants
            ]
            law = ScheduledInverse(laws=tuple(laws), weights=weights)
            truth = run.truth
            every = round(float(run.time[1] / truth.time[1]))
            path = relative_to_start(truth.tool_position[::every], truth.tool_quaternion[::every])
            u = friction_step(law, plants, loaded.model, u, target - path, run)
    return best, np.array(rms)


def twin_error(
    experiment: Experiment, run: Recording, clock: tuple[Array, Array] | None = None
) -> float:
    """RMS tool error [m] of a twin's run over all contours, as by a tracker of 1 kHz; infinite
    where it became unstable. clock: as of `Pass`."""
    truth, cut, motion = run.truth, experiment.cut, experiment.motion
    if not np.isfinite(truth.tool_position).all():
        return float("inf")
    every = slice(None, None, round(1e-3 / float(truth.time[1])))
    seen = of_motion(truth.time[every], clock), truth.tool_position[every]
    return cut.whole(motion, cut.errors(motion, *seen, edges=False)).rms


def _twin_plants(
    design: RobotDesign, loaded: LoadedReference, run: Recording, places: Array, weights: Array
) -> PathPlants:
    """Responses of the tool to corrections, linearised at places (S, 6) [rad], with the mean slope
    of each gear along a run of the twin: one without load stays within its lost motion, and is
    soft. weights: (N, S), of places.
    """
    own = 0.0 if design.payload is None else design.payload - design.model.mj.body("tool").mass[0]
    arm = nominal_arm(design.model, NominalCfg(structure=True, payload=float(own)))
    twin = loaded.model.mj
    for joint in (*joints(twin, "struct_"), *joints(twin, "hidden_")):
        same = arm.mj.joint(twin.joint(joint).name).id
        arm.mj.jnt_axis[same], arm.mj.jnt_pos[same] = twin.jnt_axis[joint], twin.jnt_pos[joint]
        arm.mj.jnt_stiffness[same] = twin.jnt_stiffness[joint]
    arm = arm.with_springs(_mean_gear_stiffness(loaded.model, run), arm.damping)
    robot = design.nominal or design.model
    plants = [ArmPlant(robot=robot, arm=linearised(arm, p), period=LOG_PERIOD) for p in places]
    return PathPlants(plants=tuple(plants), weights=weights)


def _mean_gear_stiffness(model: RobotModel, run: Recording) -> Array:
    """(6,) [N m/rad], mean slope of each gear spring along a run."""
    mj, wound = model.mj, run.truth.spring_angle
    tendons = [mj.tendon(f"gear_{i}").id for i in AXES]
    low, high = mj.tendon_lengthspring[tendons].T
    outside = ((wound < low) | (wound > high)).mean(axis=0)
    soft = mj.jnt_stiffness[[mj.joint(f"flex_{i}").id for i in AXES]]
    return soft + outside * mj.tendon_stiffness[tendons]
