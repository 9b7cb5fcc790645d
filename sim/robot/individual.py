"""Robot individuals: parameters of one robot that differ from the design, and its payload."""

import copy
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .drives import N_HARMONICS
from .effects import Effect, FrictionFactors, with_effects
from .mjcf import AXES, N_AXES, ModelError, axis_actuators
from .model import RobotModel, robot_model

# dcmotor keeps amplitude and phase of its cogging here, and Coulomb and static LuGre friction and
# the Stribeck speed; stiffness and damping of the bristles among its dynamics (checked by a test
# against the MJCF).
_COGGING, _COGGING_PHASE, _COULOMB, _STATIC, _STRIBECK = 0, 2, 3, 4, 5
_BRISTLE, _BRISTLE_DAMPING = 5, 6


@dataclass(frozen=True, kw_only=True)
class HiddenHinge:
    """Elastic hinge of the structure that the design does not have."""

    body: str
    """Body of the MJCF that rests on it, behind its own joints."""
    axis: tuple[float, float, float]
    """In the axes of that body."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of a point on the axis [m], in the axes of that body."""
    stiffness: float
    """[N m/rad]."""
    damping: float
    """[N m s/rad]."""


def _ones() -> Array:
    return np.ones(N_AXES)


@dataclass(frozen=True, kw_only=True, eq=False)
class Individual:
    """Parameters of one robot relative to its design. The defaults are the design itself.

    Arrays (6,) have one value for each axis; factors multiply the value of the design.
    """

    friction: Array = field(default_factory=_ones)
    """Factor on Coulomb and static friction."""
    friction_constant: Array = field(default_factory=_ones)
    friction_load: Array = field(default_factory=_ones)
    """Factors on the two parts of load-dependent Coulomb friction."""
    static_excess: Array = field(default_factory=_ones)
    """Factor on the excess of static over Coulomb friction, where friction depends on load."""
    stribeck_speed: Array = field(default_factory=_ones)
    viscous: Array = field(default_factory=_ones)
    bristle_stiffness: Array = field(default_factory=_ones)
    """Factor on the LuGre bristles' stiffness; their damping ratio stays."""
    ripple: Array = field(default_factory=_ones)
    """Factor on the amplitude of the motor's torque ripple."""
    ripple_phase: Array = field(default_factory=lambda: np.zeros(N_AXES))
    """(6,) [rad], added to the phase of each motor's torque ripple and gear error."""
    gear_stiffness: Array = field(default_factory=_ones)
    structure_stiffness: ArrayLike = 1.0
    """(n,) factor on each hinge of the structure, or one for all."""
    gear_damping: Array = field(default_factory=_ones)
    structure_damping: ArrayLike = 1.0
    """Factors on the damping that belongs to those stiffnesses."""
    lost_motion: Array = field(default_factory=_ones)
    """Factor on the width of the soft region of a gear."""
    gear_error: Array = field(default_factory=lambda: np.ones((N_AXES, N_HARMONICS)))
    gear_error_phase: Array = field(default_factory=lambda: np.zeros((N_AXES, N_HARMONICS)))
    """(6, 4) factor on the amplitude, and [rad] added to the phase, of each order."""
    mass: Array = field(default_factory=_ones)
    """Factor on mass and inertia of the link behind each motor, without the tool."""
    position: Array = field(default_factory=lambda: np.zeros((N_AXES, 3)))
    """(6, 3) [m], added to the position of each joint's body in its parent."""
    orientation: Array = field(default_factory=lambda: np.zeros((N_AXES, 3)))
    """(6, 3) [rad], rotation vector added to the orientation of each joint's body."""
    hidden: tuple[HiddenHinge, ...] = ()


def embodied(
    design: RobotModel,
    individual: Individual,
    effects: Collection[Effect],
    *,
    phi: Array,
    payload: float | None = None,
    temperature: float | None = None,
) -> RobotModel:
    """Robot model of an individual of a design.

    Args:
        phi: (6,) [rad], motor angles at which the holding torque of load friction is computed.
        payload: mass of the tool [kg]; that of the design if None.
        temperature: of the gears [deg C]; that of the design if None.
    """
    model = with_hinges(design, individual.hidden) if individual.hidden else design
    if payload is not None:
        model = with_payload(model, payload)
    factors = FrictionFactors(
        individual.friction_constant, individual.friction_load, individual.static_excess
    )
    model = with_effects(model, effects, phi=phi, friction=factors, temperature=temperature)
    return with_individual(model, individual)


def with_individual(model: RobotModel, individual: Individual) -> RobotModel:
    """Robot model of an individual of the design `model`, which has its effects already.

    Hidden hinges, and what needs the law of load friction, are those of `embodied`.
    """
    model = with_friction(model, individual.friction)
    mj, axes = model.mj, axis_actuators(model.mj)
    mj.actuator_biasprm[axes, _STRIBECK] *= individual.stribeck_speed
    mj.actuator_damping[axes] *= individual.viscous
    mj.actuator_dynprm[axes, _BRISTLE] *= individual.bristle_stiffness
    mj.actuator_dynprm[axes, _BRISTLE_DAMPING] *= np.sqrt(individual.bristle_stiffness)
    mj.actuator_biasprm[axes, _COGGING] *= individual.ripple
    mj.actuator_biasprm[axes, _COGGING_PHASE] += individual.ripple_phase
    gears = [mj.joint(f"flex_{i}").id for i in AXES] if len(model.flex) else []
    structure = structure_hinges(model)
    stiffen(mj, gears, individual.gear_stiffness)
    stiffen(mj, structure, individual.structure_stiffness)
    mj.dof_damping[mj.jnt_dofadr[gears]] *= individual.gear_damping[: len(gears)]
    mj.dof_damping[mj.jnt_dofadr[structure]] *= np.asarray(individual.structure_damping)
    for i in AXES:
        tendon = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_TENDON, f"gear_{i}")
        if tendon >= 0:  # the stiff part of a gear with lost motion, over its joint
            mj.tendon_stiffness[tendon] *= individual.gear_stiffness[i - 1]
            mj.tendon_lengthspring[tendon] *= individual.lost_motion[i - 1]
        body = int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id])
        mj.body_mass[body] *= individual.mass[i - 1]
        mj.body_inertia[body] *= individual.mass[i - 1]
        mj.body_pos[body] += individual.position[i - 1]
        mujoco.mju_quatIntegrate(mj.body_quat[body], individual.orientation[i - 1], 1.0)
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    if (error := model.gear_error) is not None:
        phase = error.phase + individual.ripple_phase[:, None] + individual.gear_error_phase
        amplitude = error.amplitude * individual.gear_error
        model = replace(model, gear_error=replace(error, amplitude=amplitude, phase=phase))
    return model


def with_hinges(design: RobotModel, hinges: Collection[HiddenHinge]) -> RobotModel:
    """Design with further elastic hinges in its structure.

    Raises ModelError for a body that the design lacks, or a model without its parsed file.
    """
    spec = design.parsed()
    for i, hinge in enumerate(hinges):
        body = spec.body(hinge.body)
        if body is None:
            raise ModelError(f"the robot model lacks the body {hinge.body} of a hidden hinge")
        joint = body.add_joint(name=f"hidden_{i}", type=mujoco.mjtJoint.mjJNT_HINGE)
        joint.axis, joint.pos = np.array(hinge.axis), np.array(hinge.position)
        joint.stiffness = _linear(hinge.stiffness, joint.stiffness)
        joint.damping = _linear(hinge.damping, joint.damping)
    return robot_model(spec)


def _linear(coefficient: float, like: Array) -> Array:
    """Polynomial of a spring or damper, shaped as another, with its linear term alone."""
    polynomial = np.zeros_like(like)
    polynomial.flat[0] = coefficient
    return polynomial


def structure_hinges(model: RobotModel) -> list[int]:
    """Joints that are hinges of the structure."""
    return joints(model.mj, "struct_")


def joints(mj: mujoco.MjModel, prefix: str) -> list[int]:
    """Joints whose name starts with a prefix."""
    return [i for i in range(mj.njnt) if mj.joint(i).name.startswith(prefix)]


def stiffen(mj: mujoco.MjModel, springs: Sequence[int], factor: ArrayLike) -> None:
    """Scale the stiffness of joint springs and, for equal damping ratios, their damping."""
    factor = np.asarray(factor, dtype=np.float64)
    mj.jnt_stiffness[springs] *= factor
    mj.dof_damping[mj.jnt_dofadr[springs]] *= np.sqrt(factor)


def with_payload(model: RobotModel, mass: float) -> RobotModel:
    """Robot model with a tool of that mass [kg]: same centre of mass, inertia in proportion.

    Raises ValueError for a negative mass, or a robot whose model has no body `tool` of its own.
    """
    if not (np.isfinite(mass) and mass >= 0.0):
        raise ValueError(f"payload must be >= 0 kg, got {mass:g}")
    mj = copy.copy(model.mj)
    tool = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_BODY, "tool")
    if tool < 0:
        raise ValueError("this robot's payload cannot be changed: its model lacks the body tool")
    mj.body_inertia[tool] *= mass / mj.body_mass[tool]
    mj.body_mass[tool] = mass
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    return replace(model, mj=mj)


def with_friction(model: RobotModel, factor: ArrayLike) -> RobotModel:
    """Robot model with Coulomb and static friction scaled by one factor > 0 or (6,)."""
    factor = np.broadcast_to(np.asarray(factor, dtype=np.float64), (N_AXES,))
    if not (np.isfinite(factor).all() and (factor > 0.0).all()):
        raise ValueError(f"friction factors must be > 0, got {factor.tolist()}")
    mj = copy.copy(model.mj)
    for kind in (_COULOMB, _STATIC):
        mj.actuator_biasprm[axis_actuators(mj), kind] *= factor
    return replace(model, mj=mj)
