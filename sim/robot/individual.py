"""Robot individuals: parameters of one robot that differ from the design, and its payload."""

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armside.arrays import Array

from .mjcf import AXES, N_AXES, axis_actuators
from .model import RobotModel

# dcmotor keeps the phase of its cogging here, and Coulomb and static LuGre friction (checked by a
# test against the MJCF).
_COGGING_PHASE, _COULOMB, _STATIC = 2, 3, 4


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Standard deviations between robots of one design, all of them ESTIMATES."""

    friction: float = 0.10
    """log(factor) on each axis: run-in, grease and temperature."""
    gear_stiffness: float = 0.10
    structure_stiffness: float = 0.10
    """log(factor) on each axis, and on each hinge of the structure."""
    position: float = 0.5e-3
    """[m], position of each joint on the link before it, each direction."""
    orientation: float = 0.5e-3
    """[rad], rotation of each joint's axis and zero, about each direction."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"spread of {item.name} must be >= 0, got {value}")


@dataclass(frozen=True, kw_only=True, eq=False)
class Individual:
    """Parameters of one robot relative to its design. The defaults are the design itself."""

    friction: Array = field(default_factory=lambda: np.ones(N_AXES))
    gear_stiffness: Array = field(default_factory=lambda: np.ones(N_AXES))
    """(6,) factors on Coulomb and static friction, and on the stiffness of the gears."""
    structure_stiffness: ArrayLike = 1.0
    """(n,) factor on each hinge of the structure, or one for all."""
    ripple_phase: Array = field(default_factory=lambda: np.zeros(N_AXES))
    """(6,) [rad], added to the phase of each motor's torque ripple and gear error."""
    position: Array = field(default_factory=lambda: np.zeros((N_AXES, 3)))
    """(6, 3) [m], added to the position of each joint's body in its parent."""
    orientation: Array = field(default_factory=lambda: np.zeros((N_AXES, 3)))
    """(6, 3) [rad], rotation vector added to the orientation of each joint's body."""


def draw(rng: np.random.Generator, n_structure: int, spread: Spread = Spread()) -> Individual:
    """Individual of a model with n `structure_hinges`: factors log-normal, phases uniform."""
    return Individual(
        friction=np.exp(spread.friction * rng.standard_normal(N_AXES)),
        gear_stiffness=np.exp(spread.gear_stiffness * rng.standard_normal(N_AXES)),
        structure_stiffness=np.exp(spread.structure_stiffness * rng.standard_normal(n_structure)),
        ripple_phase=rng.uniform(0.0, 2.0 * np.pi, N_AXES),
        position=spread.position * rng.standard_normal((N_AXES, 3)),
        orientation=spread.orientation * rng.standard_normal((N_AXES, 3)),
    )


def with_individual(model: RobotModel, individual: Individual) -> RobotModel:
    """Robot model of an individual of the design `model`, which has its effects already."""
    model = with_friction(model, individual.friction)
    mj = model.mj
    gears = [mj.joint(f"flex_{i}").id for i in AXES] if len(model.flex) else []
    stiffen(mj, gears, individual.gear_stiffness)
    stiffen(mj, structure_hinges(model), individual.structure_stiffness)
    mj.actuator_biasprm[axis_actuators(mj), _COGGING_PHASE] += individual.ripple_phase
    for i in AXES:
        tendon = mujoco.mj_name2id(mj, mujoco.mjtObj.mjOBJ_TENDON, f"gear_{i}")
        if tendon >= 0:  # the stiff part of a gear with lost motion, over its joint
            mj.tendon_stiffness[tendon] *= individual.gear_stiffness[i - 1]
        body = int(mj.jnt_bodyid[mj.joint(f"motor_{i}").id])
        mj.body_pos[body] += individual.position[i - 1]
        mujoco.mju_quatIntegrate(mj.body_quat[body], individual.orientation[i - 1], 1.0)
    mujoco.mj_setConst(mj, mujoco.MjData(mj))
    if model.gear_error is not None:
        phase = model.gear_error.phase + individual.ripple_phase[:, None]
        model = replace(model, gear_error=replace(model.gear_error, phase=phase))
    return model


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
