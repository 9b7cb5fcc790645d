"""Robot individuals: parameters of one robot that differ from the design, and its payload."""

import copy
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .alien import RUN_FRICTION, AlienEffect, built, tuned
from .drives import N_HARMONICS
from .effects import Effect, FrictionFactors, available, with_effects
from .mjcf import ModelError, axes_of, axis_actuators
from .model import RobotModel, robot_model

# dcmotor keeps amplitude and phase of its cogging here, and Coulomb and static LuGre friction and
# the Stribeck speed; stiffness and damping of the bristles among its dynamics (checked by a test
# against the MJCF).
_COGGING, _COGGING_PHASE, _COULOMB, _STATIC, _STRIBECK = 0, 2, 3, 4, 5
_BRISTLE, _BRISTLE_DAMPING = 5, 6

_SAME_AXIS = 1e-3  # [rad] and [m], between two hinges of a body that count as one


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

    def __post_init__(self) -> None:
        if not (isinstance(self.body, str) and self.body):
            raise ValueError(f"body must be the name of a body, got {self.body!r}")
        for name in ("axis", "position"):
            value = _checked(name, getattr(self, name), (3,))
            object.__setattr__(self, name, tuple(value.tolist()))
        if not np.linalg.norm(self.axis) > 0.0:
            raise ValueError(f"axis must not be zero, got {list(self.axis)}")
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, float(_checked(name, getattr(self, name), ())))
        if not self.stiffness > 0.0:
            raise ValueError(f"stiffness must be > 0 N m/rad, got {self.stiffness:g}")
        if not self.damping >= 0.0:
            raise ValueError(f"damping must be >= 0 N m s/rad, got {self.damping:g}")


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """A read-only copy. Raises ValueError for another shape or values that are not finite."""
    array = np.array(value, dtype=np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        numbers = " x ".join(map(str, shape)) + " finite numbers" if shape else "a finite number"
        found = f"shape {array.shape}" if array.shape != shape else f"{array.tolist()}"
        raise ValueError(f"{name} must be {numbers}, got {found}")
    array.setflags(write=False)
    return array


def _one() -> Array:
    return np.ones(())


def _zero() -> Array:
    return np.zeros(())


@dataclass(frozen=True, kw_only=True, eq=False)
class Individual:
    """Parameters of one robot relative to its design. The defaults are the design itself.

    Each field is one number for all axes, or an array (n,) with one for each of the n axes; factors
    multiply the value of the design.
    """

    friction: Array = field(default_factory=_one)
    """Factor on Coulomb and static friction."""
    friction_constant: Array = field(default_factory=_one)
    friction_load: Array = field(default_factory=_one)
    """Factors on the two parts of load-dependent Coulomb friction."""
    static_excess: Array = field(default_factory=_one)
    """Factor on the excess of static over Coulomb friction, where friction depends on load."""
    stribeck_speed: Array = field(default_factory=_one)
    viscous: Array = field(default_factory=_one)
    bristle_stiffness: Array = field(default_factory=_one)
    """Factor on the LuGre bristles' stiffness; their damping ratio stays."""
    ripple: Array = field(default_factory=_one)
    """Factor on the amplitude of the motor's torque ripple."""
    ripple_phase: Array = field(default_factory=_zero)
    """(n,) [rad], added to the phase of each motor's torque ripple and gear error."""
    gear_stiffness: Array = field(default_factory=_one)
    structure_stiffness: ArrayLike = 1.0
    """(h,) factor on each hinge of the structure, or one for all."""
    gear_damping: Array = field(default_factory=_one)
    structure_damping: ArrayLike = 1.0
    """Factors on the damping that belongs to those stiffnesses."""
    lost_motion: Array = field(default_factory=_one)
    """Factor on the width of the soft region of a gear."""
    gear_error: Array = field(default_factory=_one)
    gear_error_phase: Array = field(default_factory=_zero)
    """(n, 4) factor on the amplitude, and [rad] added to the phase, of each order."""
    mass: Array = field(default_factory=_one)
    """Factor on mass and inertia of all that each motor carries up to the next, but the tool."""
    centre_of_mass: Array = field(default_factory=_zero)
    """(n, 3) [m], added to the centre of mass of the body behind each motor, in its own axes."""
    position: Array = field(default_factory=_zero)
    """(n, 3) [m], added to the position of each joint's body in its parent."""
    orientation: Array = field(default_factory=_zero)
    """(n, 3) [rad], rotation vector added to the orientation of each joint's body."""
    hidden: tuple[HiddenHinge, ...] = ()
    alien: tuple[AlienEffect, ...] = ()
    """Effects of `spread.Alien`; hysteresis also of a twin that identified it."""

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.name in NOT_NUMBERS:
                continue
            value = getattr(self, item.name)
            object.__setattr__(self, item.name, _one_or_each(item.name, value))

    def of(self, n_axes: int) -> "Individual":
        """The individual with every number spread over the axes: (n,), (n, 4) or (n, 3).

        Raises ModelError for values for another number of axes.
        """
        every: dict[str, Any] = {}
        for name in (item.name for item in fields(self)):
            if name in (*NOT_NUMBERS, *OF_STRUCTURE):
                continue
            if (value := getattr(self, name)).ndim and len(value) != n_axes:
                allowed = f"one number or {n_axes}, one for each axis"
                raise ModelError(f"{name} must be {allowed}, got {len(value)}")
            every[name] = np.broadcast_to(value, (n_axes, *_MORE.get(name, ())))
        return replace(self, **every)


NOT_NUMBERS = ("hidden", "alien")
OF_STRUCTURE = ("structure_stiffness", "structure_damping")
"""Fields with a value for each hinge of the structure, or one for all."""
_MORE: Mapping[str, tuple[int, ...]] = {
    **dict.fromkeys(("gear_error", "gear_error_phase"), (N_HARMONICS,)),
    **dict.fromkeys(("centre_of_mass", "position", "orientation"), (3,)),
}
"""Shape of the values of each axis, of the fields that have more than one."""


def _one_or_each(name: str, value: ArrayLike) -> Array:
    """A read-only copy, of one number or of values for each axis. Raises ValueError else."""
    more, shape = _MORE.get(name, ()), np.shape(value)
    if shape == () or (len(shape) == 1 + len(more) and shape[0] > 0 and shape[1:] == more):
        return _checked(name, value, shape)
    each = "hinge" if name in OF_STRUCTURE else "axis"
    rows = f" row of {more[0]}" if more else ""
    raise ValueError(f"{name} must be one number or one{rows} for each {each}, got shape {shape}")


def embodied(
    design: RobotModel,
    individual: Individual,
    effects: Collection[Effect],
    *,
    phi: Array,
    payload: float | None = None,
    temperature: float | None = None,
) -> RobotModel:
    """Robot model of an individual, its load friction that of the holding torque at phi (n,) [rad].

    payload: mass of the tool [kg], temperature: of the gears [deg C]; those of the design if None.
    """
    individual = individual.of(design.n_axes)
    model = with_hinges(design, individual.hidden) if individual.hidden else design
    model = built(model, individual.alien)
    if payload is not None:
        model = with_payload(model, payload)
    factors = FrictionFactors(
        individual.friction_constant, individual.friction_load, individual.static_excess
    )
    left_out = {RUN_FRICTION} if Effect.LOAD_FRICTION in available(design) - set(effects) else set()
    alien = [each for each in individual.alien if each.name not in left_out]
    model = with_effects(model, effects, phi=phi, friction=factors, temperature=temperature)
    return tuned(with_individual(model, individual), alien, temperature)


def with_individual(model: RobotModel, individual: Individual) -> RobotModel:
    """Robot model of an individual of the design `model`, with its effects and hidden hinges."""
    individual = individual.of(model.n_axes)
    model = with_friction(model, individual.friction)
    numbers = axes_of(model.mj)
    mj, axes = model.mj, axis_actuators(model.mj)
    mj.actuator_biasprm[axes, _STRIBECK] *= individual.stribeck_speed
    mj.actuator_damping[axes] *= individual.viscous
    mj.actuator_dynprm[axes, _BRISTLE] *= individual.bristle_stiffness
    mj.actuator_dynprm[axes, _BRISTLE_DAMPING] *= np.sqrt(individual.bristle_stiffness)
    mj.actuator_biasprm[axes, _COGGING] *= individual.ripple
    mj.actuator_biasprm[axes, _COGGING_PHASE] += individual.ripple_phase
    gears = [mj.joint(f"flex_{i}").id for i in numbers] if len(model.flex) else []
    structure = structure_hinges(model)
    stiffen(mj, gears, individual.gear_stiffness)
    stiffen(mj, structure, individual.structure_stiffness)
    mj.dof_damping[mj.jnt_dofadr[gears]] *= individual.gear_damping[: len(gears)]
    mj.dof_damping[mj.jnt_dofadr[structure]] *= np.asarray(individual.structure_damping)
    motors = {int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id]) for i in numbers}
    for i in numbers:
        tendon = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_TENDON, f"gear_{i}")
        if tendon >= 0:  # the stiff part of a gear with lost motion, over its joint
            mj.tendon_stiffness[tendon] *= individual.gear_stiffness[i - 1]
            mj.tendon_lengthspring[tendon] *= individual.lost_motion[i - 1]
        body = int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id])
        moved = [body]  # up to the next motor; a parent comes before its children
        for other in range(body + 1, mj.nbody):
            if other not in motors and int(mj.body_parentid[other]) in moved:
                moved.append(other)
        carried = [other for other in moved if mj.body(other).name != "tool"]
        mj.body_mass[carried] *= individual.mass[i - 1]
        mj.body_inertia[carried] *= individual.mass[i - 1]
        mj.body_ipos[body] += individual.centre_of_mass[i - 1]
        mj.body_pos[body] += individual.position[i - 1]
        mujoco.mju_quatIntegrate(mj.body_quat[body], individual.orientation[i - 1], 1.0)
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    if (error := model.gear_error) is not None:
        phase = error.phase + individual.ripple_phase[:, None] + individual.gear_error_phase
        amplitude = error.amplitude * individual.gear_error
        model = replace(model, gear_error=replace(error, amplitude=amplitude, phase=phase))
    return model


def as_built(design: RobotModel, individual: Individual) -> RobotModel:
    """Individual of a design without effects and its tool, with the parsed file of its numbers."""
    model = with_individual(with_hinges(design, individual.hidden), individual)
    spec = model.parsed()
    spec.copy_back(model.mj)
    return replace(model, spec=spec)


def with_hinges(
    design: RobotModel, hinges: Collection[HiddenHinge], name: str = "hidden"
) -> RobotModel:
    """Design with further elastic hinges in its structure, called NAME_0 and so on.

    Raises ModelError for a body that it lacks, a hinge on the axis of another, or no parsed file.
    """
    spec = design.parsed()
    bodies = [body.name for body in spec.bodies if body.name not in ("", "world")]
    for i, hinge in enumerate(hinges):
        if hinge.body not in bodies:
            known = f"Bodies: {', '.join(bodies)}"
            raise ModelError(f"a hidden hinge needs a body, got {hinge.body!r}. {known}")
        body, position = spec.body(hinge.body), np.array(hinge.position)
        axis = np.array(hinge.axis) / np.linalg.norm(hinge.axis)
        for other in body.joints:  # no mass would lie between two hinges on one axis
            parallel = np.linalg.norm(np.cross(axis, other.axis)) < _SAME_AXIS
            if parallel and np.linalg.norm(np.cross(axis, position - other.pos)) < _SAME_AXIS:
                where = f"{other.name} of the body {hinge.body}"
                raise ModelError(f"a hidden hinge lies on the axis of {where}: move or turn it")
        joint = body.add_joint(name=f"{name}_{i}", type=mujoco.mjtJoint.mjJNT_HINGE)
        joint.axis, joint.pos = np.array(hinge.axis), position
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
    """Robot model with Coulomb and static friction scaled by one factor > 0 or (n,)."""
    factor = np.broadcast_to(np.asarray(factor, dtype=np.float64), (model.n_axes,))
    if not (np.isfinite(factor).all() and (factor > 0.0).all()):
        raise ValueError(f"friction factors must be > 0, got {factor.tolist()}")
    mj = copy.copy(model.mj)
    for kind in (_COULOMB, _STATIC):
        mj.actuator_biasprm[axis_actuators(mj), kind] *= factor
    return replace(model, mj=mj)
